#include "services/calibrate/scene/rectify_again.h"

#include "common/rig/bilinear_remap.h"

namespace sprout::calibrate {

cv::Mat RectifyAgain(const cv::Mat& image, const RectifiedCamera& from, const RectifiedCamera& to) {
  cv::Mat2f places(to.pair.size());
  const Eigen::Matrix3d back = BackOf(to.turn);
  for (int v = 0; v < places.rows; ++v) {
    for (int u = 0; u < places.cols; ++u) {
      const Eigen::Vector2d raw = RawPixel(to.lens, back, to.pair, to.cx, u, v);
      const cv::Point2d place =
          RectifiedPixel(from.lens, from.turn, from.pair, from.cx, {raw.x(), raw.y()});
      places(v, u) = {static_cast<float>(place.x), static_cast<float>(place.y)};
    }
  }
  return BilinearRemap(places, image.size()).Apply(image);
}

}  // namespace sprout::calibrate
