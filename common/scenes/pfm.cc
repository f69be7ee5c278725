#include "common/scenes/pfm.h"

#include <cmath>
#include <fstream>
#include <iterator>
#include <opencv2/imgcodecs.hpp>
#include <string>

#include "common/config/config_error.h"
#include "common/core/image.h"
#include "common/core/input_files.h"
#include "common/scenes/read_image.h"

namespace sprout::scenes {
namespace {

struct Header {
  int width = 0;
  int height = 0;
  double scale = 0;
};

ConfigError BadPfm(const std::filesystem::path& path, const std::string& reason) {
  return ConfigError(path.string() + ": " + reason +
                     "; allowed: a one-channel PFM file (Pf, width, height, scale, samples)");
}

Header ReadHeader(std::ifstream& file, const std::filesystem::path& path) {
  std::string magic;
  Header header;
  file.width(3);  // what is no PFM may be one word of gigabytes
  file >> magic >> header.width >> header.height >> header.scale;
  if (!file || magic != "Pf") throw BadPfm(path, "not such a header");
  // The one white space that ends the header; two where lines end as on Windows.
  if (file.get() == '\r' && file.peek() == '\n') file.get();
  if (header.width < 1 || header.width > kMaxSide || header.height < 1 ||
      header.height > kMaxSide) {
    throw BadPfm(path, "size " + std::to_string(header.width) + "x" +
                           std::to_string(header.height) + " is not 1 to " +
                           std::to_string(kMaxSide) + " px a side");
  }
  if (!std::isfinite(header.scale) || header.scale == 0) throw BadPfm(path, "scale is 0");
  return header;
}

}  // namespace

cv::Mat1f ReadPfm(const std::filesystem::path& path) {
  if (!IsFile(path)) throw BadPfm(path, "not a file");
  NoteInputFile(path);
  std::ifstream file(path, std::ios::binary);
  if (!file) throw BadPfm(path, "cannot be read");
  const Header header = ReadHeader(file, path);
  // The size is checked before anything is allocated: the header may promise more than the file
  // holds. With a byte more the samples may begin elsewhere.
  const auto begin = static_cast<uintmax_t>(file.tellg());
  const uintmax_t sample_bytes =
      sizeof(float) * static_cast<uintmax_t>(header.width) * static_cast<uintmax_t>(header.height);
  std::error_code error;
  const uintmax_t file_bytes = std::filesystem::file_size(path, error);
  if (error || file_bytes < begin + sample_bytes) throw BadPfm(path, "ends early");
  if (file_bytes > begin + sample_bytes) {
    throw BadPfm(path,
                 std::to_string(file_bytes - begin - sample_bytes) + " bytes behind the samples");
  }
  // OpenCV divides by the scale, which in Middlebury's files means nothing but the byte order.
  std::string pfm = "Pf\n" + std::to_string(header.width) + " " + std::to_string(header.height) +
                    (header.scale < 0 ? "\n-1\n" : "\n1\n");
  pfm.append(std::istreambuf_iterator<char>(file), {});
  const cv::Mat1b bytes(1, static_cast<int>(pfm.size()), reinterpret_cast<uchar*>(pfm.data()));
  const cv::Mat samples = cv::imdecode(bytes, cv::IMREAD_UNCHANGED);
  if (samples.type() != CV_32FC1) throw BadPfm(path, "cannot be decoded");
  return samples;
}

}  // namespace sprout::scenes
