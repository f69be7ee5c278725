#include "common/picture/write_image.h"

#include <cmath>
#include <limits>
#include <opencv2/imgcodecs.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "common/core/output_file.h"

namespace sprout {

void RequireWritten(const Result<void>& written) {
  if (!written) throw std::runtime_error(written.error().text);
}

Result<void> WritePng(const std::filesystem::path& path, const cv::Mat& picture) {
  if (picture.empty()) return Fail("cannot write " + path.string() + ": the picture is empty");
  std::vector<uchar> png;
  if (!cv::imencode(".png", picture, png)) {
    return Fail("cannot write " + path.string() + ": PNG encoding failed");
  }
  OutputFile file(path);
  file.Write({reinterpret_cast<const char*>(png.data()), png.size()});
  return file.Commit();
}

Result<void> WriteDepthPng(const std::filesystem::path& path, const cv::Mat1f& depth_m) {
  cv::Mat1w mm(depth_m.size(), uint16_t{0});
  for (int v = 0; v < depth_m.rows; ++v) {
    for (int u = 0; u < depth_m.cols; ++u) {
      const double depth = double{depth_m(v, u)};
      if (depth > 0 && depth < kMaxPngDepthM + 0.0005) {  // 65535 mm when rounded
        mm(v, u) = static_cast<uint16_t>(std::lround(depth * 1000));
      }
    }
  }
  return WritePng(path, mm);
}

Result<void> WritePfm(const std::filesystem::path& path, const cv::Mat1f& values) {
  if (values.empty()) return Fail("cannot write " + path.string() + ": the map is empty");
  OutputFile file(path);
  // cv::imencode() is not used: it writes PFM to a temporary file first and does not notice that
  // the disk is full. The sign of the scale says little-endian.
  file.Write("Pf\n" + std::to_string(values.cols) + " " + std::to_string(values.rows) + "\n-1.0\n");
  for (int v = values.rows - 1; v >= 0; --v) {
    for (int u = 0; u < values.cols; ++u) file.WriteNumber(values(v, u));
  }
  return file.Commit();
}

Result<void> WritePfm(const std::filesystem::path& path, const DisparityImage& disparity) {
  cv::Mat1f px = ToPx(disparity);
  px.setTo(std::numeric_limits<float>::infinity(), disparity.counts() == DisparityImage::kInvalid);
  return WritePfm(path, px);
}

}  // namespace sprout
