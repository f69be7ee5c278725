#include "common/picture/write_image.h"

#include <limits>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "common/core/output_file.h"

namespace sprout {

namespace {

// @param extension  names the format, as OpenCV knows it.
Result<void> Write(const std::filesystem::path& path, const cv::Mat& picture,
                   const char* extension) {
  if (picture.empty()) return Fail("cannot write " + path.string() + ": the picture is empty");
  std::vector<uchar> bytes;
  if (!cv::imencode(extension, picture, bytes)) {
    return Fail("cannot write " + path.string() + ": encoding failed");
  }
  OutputFile file(path);
  file.Write({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  return file.Commit();
}

}  // namespace

Result<void> WritePng(const std::filesystem::path& path, const cv::Mat& picture) {
  return Write(path, picture, ".png");
}

Result<void> WritePfm(const std::filesystem::path& path, const DisparityImage& disparity) {
  cv::Mat1f px = ToPx(disparity);
  px.setTo(std::numeric_limits<float>::infinity(), disparity.counts() == DisparityImage::kInvalid);
  return Write(path, px, ".pfm");
}

}  // namespace sprout
