#include "common/core/image.h"

#include <opencv2/imgproc.hpp>

namespace sprout {

cv::Mat1b ToGrey(const cv::Mat& image) {
  cv::Mat1b grey;
  return ToGrey(image, grey);
}

cv::Mat1b ToGrey(const cv::Mat& image, cv::Mat1b& memory) {
  if (image.channels() == 1) return image;
  cv::cvtColor(image, memory, cv::COLOR_BGR2GRAY);
  return memory;
}

cv::Mat3b ToBgr(const cv::Mat& image) {
  cv::Mat3b bgr;
  return ToBgr(image, bgr);
}

cv::Mat3b ToBgr(const cv::Mat& image, cv::Mat3b& memory) {
  if (image.channels() == 3) return image;
  cv::cvtColor(image, memory, cv::COLOR_GRAY2BGR);
  return memory;
}

cv::Mat1b Halved(const cv::Mat1b& image) {
  cv::Mat1b even = image;
  if (image.rows % 2 != 0 || image.cols % 2 != 0) {
    cv::copyMakeBorder(image, even, 0, image.rows % 2, 0, image.cols % 2, cv::BORDER_REPLICATE);
  }
  cv::Mat1b half;
  cv::resize(even, half, even.size() / 2, 0, 0, cv::INTER_AREA);
  return half;
}

std::string SizeText(cv::Size size) {
  return std::to_string(size.width) + "x" + std::to_string(size.height);
}

Result<void> CheckImageSize(const std::string& what, cv::Size size, cv::Size calibrated) {
  if (size == calibrated) return {};
  return Fail(what + " of " + SizeText(size) + ": allowed is " +
              (calibrated.empty() ? "none, the calibration has none"
                                  : "the calibrated size " + SizeText(calibrated)));
}

}  // namespace sprout
