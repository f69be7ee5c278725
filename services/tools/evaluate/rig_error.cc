#include "services/tools/evaluate/rig_error.h"

#include <algorithm>
#include <numbers>
#include <string_view>
#include <utility>

#include "common/core/image.h"
#include "common/core/number_text.h"
#include "common/rig/rectifier.h"
#include "services/tools/calibrate/scene/scene_refiner.h"

namespace sprout::evaluate {
namespace {

using calibrate::RectifiedCamera;

// Largest error that may be simulated, px or degrees.
constexpr double kMaxSize = 10;

ConfigError BadError(const std::string& text) {
  return ConfigError("--rig-error " + text +
                     ": allowed is rows=N (px), roll=N or yaw=N (degrees), N from -10 to 10, and "
                     "behind it ?refined or ?known");
}

cv::Matx33d TurnOf(const RawRig& rig) {
  const Eigen::Matrix3d turn = rig.left_from_right.rotation.toRotationMatrix();
  return {turn(0, 0), turn(0, 1), turn(0, 2), turn(1, 0), turn(1, 1),
          turn(1, 2), turn(2, 0), turn(2, 1), turn(2, 2)};
}

// The right camera of a rig whose left one needs no rotation.
RectifiedCamera RightCamera(const RawRig& rig, const RectifiedPair& pair) {
  return {.lens = rig.right, .turn = TurnOf(rig), .pair = pair, .cx = pair.cx_right};
}

// The camera of an image that is not rectified.
RectifiedCamera RawCamera(const RawRig& rig, RectifiedPair pair) {
  pair.cy = rig.right.cy;
  return {.lens = rig.right, .turn = cv::Matx33d::eye(), .pair = pair, .cx = rig.right.cx};
}

// The text before the first `mark`, and the rest from it on.
std::pair<std::string_view, std::string_view> CutAt(std::string_view text, char mark) {
  const auto at = std::ranges::find(text, mark);
  return {{text.begin(), at}, {at, text.end()}};
}

}  // namespace

RigError::RigError(const std::string& text) {
  const auto [error, known] = CutAt(text, '?');
  const auto [name, value] = CutAt(error, '=');
  const auto size = ParseNumber<double>(value.substr(value.empty() ? 0 : 1));
  if (!size || !(*size >= -kMaxSize && *size <= kMaxSize)) throw BadError(text);
  constexpr double kDegree = std::numbers::pi / 180;
  if (name == "rows") {
    error_[calibrate::kRowRight] = *size;
  } else if (name == "roll") {
    error_[calibrate::kRoll] = *size * kDegree;
  } else if (name == "yaw") {
    error_[calibrate::kYaw] = *size * kDegree;
  } else {
    throw BadError(text);
  }
  if (known == "?refined") {
    known_ = Known::kRefined;
  } else if (known == "?known") {
    known_ = Known::kAll;
  } else if (!known.empty()) {
    throw BadError(text);
  }
}

void RigError::Apply(Scene& scene) const {
  Rig rig = scene.projector.rig();
  const RectifiedPair pair = rig.pair;
  const RawRig believed = calibrate::RawRigOf(rig);
  const RawRig knocked = calibrate::Changed(believed, error_);
  cv::Mat right = calibrate::RectifyAgain(RightCamera(knocked, pair), RawCamera(knocked, pair))
                      .Apply(scene.frame.right);
  RawRig used = known_ == Known::kAll ? knocked : believed;
  if (known_ == Known::kRefined) {
    calibrate::SceneRefiner refiner(
        believed,
        {.left_turn = cv::Matx33d::eye(), .right_turn = cv::Matx33d::eye(), .pair = pair});
    const Result<void> added = refiner.Add(scene.frame.left, right, scene.frame.tof);
    if (!added) throw ConfigError(scene.name + ": " + added.error().text);
    const auto refined = refiner.Refine({});
    if (!refined) throw ConfigError(scene.name + ": " + refined.error().text);
    used = refined->rig;
  }
  if (known_ != Known::kNothing) {
    right = calibrate::RectifyAgain(RawCamera(used, pair), RightCamera(used, pair)).Apply(right);
  }
  rig.tof.left_from_tof_rotation = used.left_from_tof.rotation;
  if (!used.HasRightRanges()) Rectifier(used).CorrectRanges(scene.frame.tof);
  scene.frame.right = right;
  scene.right_grey = ToGrey(right);
  scene.projector = TofProjector(rig);
}

}  // namespace sprout::evaluate
