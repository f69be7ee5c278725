#include "common/core/image.h"

#include <opencv2/imgproc.hpp>

namespace sprout {

cv::Mat1b ToGrey(const cv::Mat& image) {
  if (image.channels() == 1) return image;
  cv::Mat1b grey;
  cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  return grey;
}

std::string SizeText(cv::Size size) {
  return std::to_string(size.width) + "x" + std::to_string(size.height);
}

}  // namespace sprout
