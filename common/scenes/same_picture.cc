#include "common/scenes/same_picture.h"

#include "common/core/image.h"

namespace sprout::scenes {

bool IsSamePicture(const cv::Mat& a, const cv::Mat& b) {
  if (a.size() != b.size()) return false;
  const cv::Mat1b grey_a = ToGrey(a);
  const cv::Mat1b grey_b = ToGrey(b);
  cv::Scalar mean;
  cv::Scalar deviation;
  cv::meanStdDev(grey_a, mean, deviation);
  const double difference =
      cv::norm(grey_a, grey_b, cv::NORM_L2SQR) / static_cast<double>(grey_a.total());
  // Pictures that have nothing in common differ by twice the variance. The second term is for JPEGs
  // of images with hardly any contrast.
  return difference <= 0.2 * deviation[0] * deviation[0] + 25;
}

}  // namespace sprout::scenes
