#include "services/capture/pfm.h"

#include <bit>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <string>
#include <vector>

#include "common/config/config.h"
#include "common/core/image.h"
#include "services/capture/read_image.h"

namespace sprout {
namespace {

struct Header {
  int width = 0;
  int height = 0;
  double scale = 0;
};

ConfigError BadPfm(const std::filesystem::path& path, const std::string& reason) {
  return ConfigError("ground truth " + path.string() + ": " + reason +
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

// Before anything is allocated: the header may promise what the file does not hold. And no byte
// more, or the samples may begin elsewhere.
void RequireSamples(const std::filesystem::path& path, uintmax_t begin, uintmax_t bytes) {
  std::error_code error;
  const uintmax_t file_bytes = std::filesystem::file_size(path, error);
  if (error || file_bytes < begin + bytes) throw BadPfm(path, "ends early");
  if (file_bytes == begin + bytes) return;
  throw BadPfm(path, std::to_string(file_bytes - begin - bytes) + " bytes behind the samples");
}

float SampleAt(const unsigned char* bytes, bool little_endian) {
  uint32_t bits = 0;
  for (int i = 0; i < 4; ++i) {
    bits |= uint32_t{bytes[i]} << (8 * (little_endian ? i : 3 - i));
  }
  return std::bit_cast<float>(bits);
}

}  // namespace

cv::Mat1f ReadPfm(const std::filesystem::path& path) {
  if (!IsFile(path)) throw BadPfm(path, "not a file");
  std::ifstream file(path, std::ios::binary);
  if (!file) throw BadPfm(path, "cannot be read");
  const Header header = ReadHeader(file, path);
  const size_t row_bytes = sizeof(float) * static_cast<size_t>(header.width);
  RequireSamples(path, static_cast<uintmax_t>(file.tellg()),
                 row_bytes * static_cast<size_t>(header.height));

  cv::Mat1f samples(header.height, header.width);
  std::vector<unsigned char> row(row_bytes);
  for (int v = header.height - 1; v >= 0; --v) {  // PFM stores the bottom row first
    if (!file.read(reinterpret_cast<char*>(row.data()), static_cast<std::streamsize>(row_bytes))) {
      throw BadPfm(path, "ends early");
    }
    for (int u = 0; u < header.width; ++u) {
      samples(v, u) = SampleAt(&row[sizeof(float) * static_cast<size_t>(u)], header.scale < 0);
    }
  }
  return samples;
}

}  // namespace sprout
