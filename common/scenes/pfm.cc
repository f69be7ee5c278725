#include "common/scenes/pfm.h"

#include <array>
#include <cmath>
#include <fstream>
#include <iterator>
#include <opencv2/imgcodecs.hpp>
#include <string_view>
#include <system_error>
#include <vector>

#include "common/config/required.h"
#include "common/core/depth_of_counts.h"
#include "common/core/image.h"
#include "common/core/input_files.h"
#include "common/core/number_text.h"
#include "common/picture/read_image.h"

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

bool IsPfm(const std::filesystem::path& path) {
  std::array<char, 2> magic{};
  if (!IsFile(path)) return false;  // a pipe would wait
  std::ifstream(path, std::ios::binary).read(magic.data(), magic.size());
  return magic[0] == 'P' && (magic[1] == 'f' || magic[1] == 'F');
}

// The pixels of a grey image that was saved in colour, 0 where alpha is; others stay as they are.
cv::Mat GreyOf(const cv::Mat& image) {
  std::vector<cv::Mat> planes;
  cv::split(image, planes);
  const bool is_grey = cv::countNonZero((planes[0] != planes[1]) | (planes[0] != planes[2])) == 0;
  const bool is_mask =
      planes.size() == 3 || cv::countNonZero((planes[3] != 0) & (planes[3] != 65535)) == 0;
  if (!is_grey || !is_mask) return image;
  if (planes.size() == 4) planes[0].setTo(0, planes[3] == 0);
  return planes[0];
}

}  // namespace

bool IsFile(const std::filesystem::path& path) {
  std::error_code ignored;
  return std::filesystem::is_regular_file(path, ignored);
}

cv::Mat ReadImage(const std::filesystem::path& path, int flags) {
  return Required(DecodeImageFile(path, flags, kPictureFormats));
}

void RequireSize(const std::filesystem::path& path, cv::Size size, cv::Size expected) {
  if (size == expected) return;
  throw ConfigError("scene file " + path.string() + ": " + SizeText(size) +
                    " px; allowed: " + SizeText(expected) + " px, as the left image has");
}

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

std::optional<double> ParseRangeUnit(const std::string& text) {
  std::optional<double> metres;
  if (text == "mm") {
    metres = kMetresPerMillimetre;
  } else if (text == "cm") {
    metres = 0.01;
  } else if (text == "m") {
    metres = 1;
  } else if (text.starts_with("1/")) {
    const std::optional<double> counts = ParseNumber<double>(std::string_view(text).substr(2));
    if (counts && *counts != 0) metres = 1 / *counts;
  } else {
    metres = ParseNumber<double>(text);
  }
  if (metres && (*metres < 1e-6 || *metres > 1000)) return std::nullopt;
  return metres;
}

Result<cv::Mat1f> ReadRangeFile(const std::filesystem::path& path, std::optional<double> unit_m) {
  cv::Mat image;
  if (IsPfm(path)) {
    try {
      image = ReadPfm(path);
    } catch (const ConfigError& e) {
      return Fail(e.what());
    }
  } else {
    Result<cv::Mat> decoded = DecodeImageFile(path, cv::IMREAD_UNCHANGED, kCameraFormats);
    if (!decoded) return tl::unexpected(decoded.error());
    image = std::move(*decoded);
  }
  if (image.depth() == CV_16U && image.channels() >= 3) image = GreyOf(image);
  if (image.type() == CV_16UC1) {
    return DepthOfCounts(image, unit_m.value_or(kMetresPerMillimetre));
  }
  if (image.type() != CV_32FC1 && image.type() != CV_64FC1) {
    return Fail("range image " + path.string() + ": of OpenCV's type " +
                cv::typeToString(image.type()) +
                "; allowed: one channel of 16 bits (mm), or of floating point (m; PFM, TIFF)");
  }
  cv::Mat1f depth_m;
  image.convertTo(depth_m, CV_32F, unit_m.value_or(1));
  return depth_m;
}

}  // namespace sprout::scenes
