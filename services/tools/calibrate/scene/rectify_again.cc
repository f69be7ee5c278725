#include "services/tools/calibrate/scene/rectify_again.h"

namespace sprout::calibrate {

BilinearRemap RectifyAgain(const RectifiedCamera& from, const RectifiedCamera& to) {
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
  return {places, from.pair.size()};
}

}  // namespace sprout::calibrate
