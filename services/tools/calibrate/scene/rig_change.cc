#include "services/tools/calibrate/scene/rig_change.h"

#include <cmath>
#include <numbers>
#include <utility>

namespace sprout::calibrate {
namespace {

constexpr double kDegrees = 180 / std::numbers::pi;
constexpr double kPercent = 100;
constexpr double kMm = 1000;

// What is expected: half a degree of a camera that was knocked (the issue of most rigs), a degree
// of the ToF camera, whose housing is separate; half a percent of a focal length between cold and
// warm, and three rows of a lens that moved on its mount; 30 mm of a warm ToF camera.
constexpr std::array<RigNumberRow, kRigNumbers> kNumberRows = {{
    {"right camera, pitch", "°", kDegrees, 4, 0.5 / kDegrees},
    {"right camera, yaw", "°", kDegrees, 4, 0.5 / kDegrees},
    {"right camera, roll", "°", kDegrees, 4, 0.5 / kDegrees},
    {"baseline, turned down", "°", kDegrees, 4, 0.5 / kDegrees},
    {"baseline, turned forward", "°", kDegrees, 4, 0.5 / kDegrees},
    {"focal lengths", "%", kPercent, 3, 0.005},
    {"right focal length alone", "%", kPercent, 3, 0.005},
    {"right principal row", "px", 1, 2, 3},
    {"ToF camera, pitch", "°", kDegrees, 4, 1 / kDegrees},
    {"ToF camera, yaw", "°", kDegrees, 4, 1 / kDegrees},
    {"ToF camera, roll", "°", kDegrees, 4, 1 / kDegrees},
    {"ToF ranges", "mm", kMm, 1, 0.03},
}};

Pose Turned(const Pose& pose, const RigNumbers& change, RigNumber first) {
  return TurnedBy(pose, {change[first], change[first + 1], change[first + 2]});
}

Lens Scaled(Lens lens, double by) {
  lens.fx *= by;
  lens.fy *= by;
  return lens;
}

}  // namespace

Result<RigImages> RectifyImages(const Rectifier& rectifier, RigImages images) {
  const Result<void> rectified = rectifier.Rectify(images.left, images.right, images.tof);
  return rectified.map([&] { return std::move(images); });
}

const RigNumberRow& RowOf(RigNumber number) { return kNumberRows[number]; }

RawRig Changed(const RawRig& rig, const RigNumbers& change) {
  RawRig changed = rig;
  changed.left = Scaled(rig.left, 1 + change[kFocal]);
  changed.right = Scaled(rig.right, (1 + change[kFocal]) * (1 + change[kFocalRight]));
  changed.right.cy += change[kRowRight];
  changed.left_from_right = Turned(rig.left_from_right, change, kPitch);
  if (change[kPlaceY] != 0 || change[kPlaceZ] != 0) {
    const PlaceAxes axes(rig.left_from_right.translation_m);
    changed.left_from_right.translation_m = axes.Moved(change[kPlaceY], change[kPlaceZ]);
  }
  changed.left_from_tof = Turned(rig.left_from_tof, change, kTofPitch);
  changed.range_offset_m += change[kRangeOffset];
  return changed;
}

MovedPx MaxMoved(const RigNumbers& change, const RectifiedPair& pair) {
  const auto size = [&](RigNumber number) { return std::abs(change[number]); };
  const double half_px = std::hypot(pair.width, pair.height) / 2;
  // A tilt of the baseline moves a point across by its disparity, of which this is a large one.
  const double disparity_px = 0.2 * pair.width;
  return {.right = pair.focal_px * (size(kPitch) + size(kYaw)) + half_px * size(kRoll) +
                   disparity_px * (size(kPlaceY) + size(kPlaceZ)) +
                   half_px * (size(kFocal) + size(kFocalRight)) + size(kRowRight),
          .tof = pair.focal_px * (size(kTofPitch) + size(kTofYaw)) + half_px * size(kTofRoll)};
}

RawRig RawRigOf(const Rig& rig) {
  const RectifiedPair& pair = rig.pair;
  const auto lens = [&](double cx) {
    return Lens{pair.width, pair.height, pair.focal_px, pair.focal_px, cx, pair.cy, {}};
  };
  return {.left = lens(pair.cx),
          .right = lens(pair.cx_right),
          .left_from_right = {.rotation = Eigen::Quaterniond::Identity(),
                              .translation_m = {pair.baseline_m, 0, 0}},
          .tof = rig.tof.lens(),
          .left_from_tof = {.rotation = rig.tof.left_from_tof_rotation,
                            .translation_m = rig.tof.left_from_tof_translation_m}};
}

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
