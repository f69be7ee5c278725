#include "common/scenes/range_file.h"

#include <array>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <string_view>

#include "common/config/config_error.h"
#include "common/core/depth_of_counts.h"
#include "common/core/number_text.h"
#include "common/picture/read_image.h"
#include "common/scenes/pfm.h"
#include "common/scenes/read_image.h"

namespace sprout::scenes {
namespace {

bool IsPfm(const std::filesystem::path& path) {
  std::array<char, 2> magic{};
  if (!IsFile(path)) return false;  // a pipe would wait
  std::ifstream(path, std::ios::binary).read(magic.data(), magic.size());
  return magic[0] == 'P' && (magic[1] == 'f' || magic[1] == 'F');
}

}  // namespace

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
  if (image.type() == CV_16UC1) {
    return DepthOfCounts(image, unit_m.value_or(kMetresPerMillimetre));
  }
  if (image.type() != CV_32FC1) {
    return Fail("range image " + path.string() + ": of OpenCV's type " +
                cv::typeToString(image.type()) +
                "; allowed: one channel of 16 bits (mm), or of floating point (m; PFM, TIFF)");
  }
  cv::Mat1f depth_m;
  image.convertTo(depth_m, CV_32F, unit_m.value_or(1));
  return depth_m;
}

}  // namespace sprout::scenes
