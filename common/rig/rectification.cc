#include "common/rig/rectification.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>

#include "common/geometry/lens.h"

namespace sprout {
namespace {

constexpr int kGrid = 17;  // pixels a side that are looked at

cv::Matx33d CameraMatrix(const Lens& lens) {
  return {lens.fx, 0, lens.cx, 0, lens.fy, lens.cy, 0, 0, 1};
}

cv::Matx33d ToCv(const Eigen::Matrix3d& m) {
  return {m(0, 0), m(0, 1), m(0, 2), m(1, 0), m(1, 1), m(1, 2), m(2, 0), m(2, 1), m(2, 2)};
}

cv::Point2d GridPixel(cv::Size size, int column, int row) {
  return {(size.width - 1) * double(column) / (kGrid - 1),
          (size.height - 1) * double(row) / (kGrid - 1)};
}

bool IsInside(cv::Size size, double x, double y, double beyond_px) {
  return x >= -beyond_px && y >= -beyond_px && x <= size.width - 1 + beyond_px &&
         y <= size.height - 1 + beyond_px;
}

// One camera of the pair.
struct View {
  const Lens& lens;
  const cv::Matx33d& turn;
  const RectifiedPair& pair;
  double cx;

  cv::Point2d Rectified(const cv::Point2d& raw) const {
    return RectifiedPixel(lens, turn, pair, cx, raw);
  }

  double ShareKept() const {
    return Share([&](int column, int row) {
      const cv::Point2d lands = Rectified(GridPixel(lens.size(), column, row));
      return IsInside(pair.size(), lands.x, lands.y, 0);
    });
  }

  double ShareFilled() const {
    // At the edge a pixel may be repeated.
    const double beyond_px = 0.01 * std::max(lens.width, lens.height);
    const Eigen::Matrix3d back = BackOf(turn);
    return Share([&](int column, int row) {
      const cv::Point2d pixel = GridPixel(pair.size(), column, row);
      const Eigen::Vector2d raw = RawPixel(lens, back, pair, cx, pixel.x, pixel.y);
      return IsInside(lens.size(), raw.x(), raw.y(), beyond_px);
    });
  }

  // First and last rectified row of the middle column.
  std::pair<double, double> FirstAndLastRow() const {
    return {Rectified(GridPixel(lens.size(), kGrid / 2, 0)).y,
            Rectified(GridPixel(lens.size(), kGrid / 2, kGrid - 1)).y};
  }

 private:
  template <typename Test>
  static double Share(Test test) {
    int count = 0;
    for (int row = 0; row < kGrid; ++row) {
      for (int column = 0; column < kGrid; ++column) count += test(column, row) ? 1 : 0;
    }
    return double(count) / (kGrid * kGrid);
  }
};

}  // namespace

Rectification RectificationOf(const RawRig& raw) {
  // OpenCV wants the left camera in the right one's frame.
  const Eigen::Matrix3d right_from_left =
      raw.left_from_right.rotation.toRotationMatrix().transpose();
  const Eigen::Vector3d translation = -right_from_left * raw.left_from_right.translation_m;
  const cv::Vec3d t(translation.x(), translation.y(), translation.z());
  Rectification made;
  cv::Matx34d left_projection;
  cv::Matx34d right_projection;
  cv::Matx44d ignored;
  // alpha = 0: zoomed such that all pixels are seen by the camera.
  cv::stereoRectify(CameraMatrix(raw.left), raw.left.distortion, CameraMatrix(raw.right),
                    raw.right.distortion, raw.left.size(), ToCv(right_from_left), t, made.left_turn,
                    made.right_turn, left_projection, right_projection, ignored,
                    cv::CALIB_ZERO_DISPARITY, /*alpha=*/0, raw.left.size());
  made.pair = {.width = raw.left.width,
               .height = raw.left.height,
               .focal_px = left_projection(0, 0),
               .cx = left_projection(0, 2),
               .cy = left_projection(1, 2),
               .cx_right = right_projection(0, 2),
               .baseline_m = raw.left_from_right.translation_m.norm()};
  return made;
}

Rig RectifiedRig(const RawRig& raw, const Rectification& rectification) {
  Rig rig{.pair = rectification.pair, .tof = {}};
  if (raw.tof.width == 0) return rig;
  const Eigen::Matrix3d turn = BackOf(rectification.left_turn).transpose();
  rig.tof = TofCameraOf(
      raw.tof,
      {.rotation =
           Eigen::Quaterniond(turn * raw.left_from_tof.rotation.toRotationMatrix()).normalized(),
       .translation_m = turn * raw.left_from_tof.translation_m});
  return rig;
}

cv::Point2d RectifiedPixel(const Lens& lens, const cv::Matx33d& turn, const RectifiedPair& pair,
                           double cx, const cv::Point2d& raw_pixel) {
  const Eigen::Vector2d direction = DirectionOfPixel(lens, {raw_pixel.x, raw_pixel.y});
  const cv::Vec3d p = turn * cv::Vec3d(direction.x(), direction.y(), 1);
  return {pair.focal_px * p[0] / p[2] + cx, pair.focal_px * p[1] / p[2] + pair.cy};
}

Eigen::Vector2d RawPixel(const Lens& lens, const Eigen::Matrix3d& back, const RectifiedPair& pair,
                         double cx, double u, double v) {
  const Eigen::Vector3d ray =
      back * Eigen::Vector3d((u - cx) / pair.focal_px, (v - pair.cy) / pair.focal_px, 1);
  return PixelOfDirection(lens, ray.hnormalized());
}

Eigen::Matrix3d BackOf(const cv::Matx33d& turn) {
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(turn.val).transpose();
}

RectifiedViews ViewsOf(const RawRig& rig, const Rectification& rectification) {
  const RectifiedPair& pair = rectification.pair;
  const View left{rig.left, rectification.left_turn, pair, pair.cx};
  const View right{rig.right, rectification.right_turn, pair, pair.cx_right};
  const auto [left_first, left_last] = left.FirstAndLastRow();
  const auto [right_first, right_last] = right.FirstAndLastRow();
  const double common = std::min(left_last, right_last) - std::max(left_first, right_first);
  const double fewer = std::min(left_last - left_first, right_last - right_first);
  return {.rows = fewer > 0 ? std::max(common, 0.0) / fewer : 0,
          .kept = std::min(left.ShareKept(), right.ShareKept()),
          .filled = std::min(left.ShareFilled(), right.ShareFilled())};
}

std::string ViewsWarning(const RectifiedViews& views) {
  constexpr double kMuch = 0.5;
  if (views.kept >= kMuch) return {};
  return "the rectified images show " + std::to_string(std::lround(100 * views.kept)) +
         " % of what one of the cameras sees: turn both into one direction, or is the calibration "
         "that of another rig?";
}

}  // namespace sprout
