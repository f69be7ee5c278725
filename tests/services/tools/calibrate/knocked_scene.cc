#include "tests/services/tools/calibrate/knocked_scene.h"

#include <Eigen/Geometry>
#include <opencv2/imgproc.hpp>

#include "common/rig/rectifier.h"
#include "common/scenes/lens_view.h"
#include "common/scenes/sr4000.h"
#include "services/tools/calibrate/scene/rig_change.h"
#include "tests/services/tools/calibrate/board_scene.h"

namespace sprout::calibrate {
namespace {

constexpr double kFloorM = 0.9;

cv::Mat RenderCamera(const Lens& lens, const Pose& pose, const std::vector<scenes::Solid>& solids,
                     double focal_px, uint64_t noise_seed) {
  constexpr int kRays = 2;
  const scenes::LensView view(lens, pose.rotation, pose.translation_m, kRays);
  cv::Mat1f rays(view.size(), 0.F);
  view.Cast(solids, focal_px, [&](int x, int y, double, const scenes::Vec3& bgr) {
    rays(y, x) = static_cast<float>(0.114 * bgr.x + 0.587 * bgr.y + 0.299 * bgr.z);
  });
  cv::Mat1f grey;
  cv::resize(rays, grey, lens.size(), 0, 0, cv::INTER_AREA);
  cv::Mat1f noise(grey.size());
  cv::RNG random(noise_seed);
  random.fill(noise, cv::RNG::NORMAL, 0, 2);
  cv::Mat1b image;
  cv::Mat(grey + noise).convertTo(image, CV_8U);
  return image;
}

Eigen::Vector3d TurnBetween(const Pose& to, const Pose& from) {
  const Eigen::AngleAxisd turn(Eigen::Quaterniond(to.rotation) *
                               Eigen::Quaterniond(from.rotation).conjugate());
  return turn.angle() * turn.axis();
}

}  // namespace

RawRig TrueRig(cv::Size size) {
  RawRig rig = SceneRig(size);
  rig.range_scale = 1;
  rig.range_offset_m = 0;
  return rig;
}

RigImages RenderSolids(const RawRig& rig, const std::vector<scenes::Solid>& solids, uint32_t seed,
                       bool with_tof) {
  const uint64_t noise = 2 * uint64_t{seed} + 1;
  RigImages images;
  images.left = RenderCamera(rig.left, {}, solids, rig.left.fx, noise);
  images.right = RenderCamera(rig.right, rig.left_from_right, solids, rig.left.fx, noise + 1);
  if (!with_tof) return images;
  const scenes::LensView view(rig.tof, rig.left_from_tof.rotation, rig.left_from_tof.translation_m,
                              scenes::TofSamples::kPerSide);
  images.tof = scenes::Sr4000(TofCameraOf(rig.tof, rig.left_from_tof), Sr4000Config(), seed)
                   .Measure(scenes::RenderTof(view, solids, rig.left.fx), 0)
                   .tof;
  return images;
}

RigImages RenderScene(const RawRig& rig, uint32_t seed, int64_t frame, bool with_tof) {
  return RenderSolids(rig, scenes::SyntheticScene(seed, kFloorM).At(frame),
                      1000 * seed + static_cast<uint32_t>(frame), with_tof);
}

Result<SceneRefinement> RefineKnocked(const RawRig& rig, const RigNumbers& errors,
                                      const std::vector<RigImages>& frames,
                                      const SceneWishes& wishes) {
  const RawRig knocked = Changed(rig, errors);
  const Rectifier rectifier(knocked);
  SceneRefiner refiner(knocked, RectificationOf(knocked));
  for (const RigImages& frame : frames) {
    const Result<RigImages> images = RectifyImages(rectifier, frame);
    if (!images) return tl::unexpected(images.error());
    const Result<void> added = refiner.Add(images->left, images->right, images->tof);
    if (!added) return tl::unexpected(added.error());
  }
  return refiner.Refine(wishes);
}

RigNumbers ErrorsLeft(const RawRig& truth, const RawRig& rig) {
  RigNumbers errors{};
  const Eigen::Vector3d right = TurnBetween(rig.left_from_right, truth.left_from_right);
  const Eigen::Vector3d tof = TurnBetween(rig.left_from_tof, truth.left_from_tof);
  for (Eigen::Index i = 0; i < 3; ++i) {
    errors[kPitch + static_cast<size_t>(i)] = right[i];
    errors[kTofPitch + static_cast<size_t>(i)] = tof[i];
  }
  const Eigen::Vector3d place = rig.left_from_right.translation_m.normalized() -
                                truth.left_from_right.translation_m.normalized();
  errors[kPlaceY] = place.y();
  errors[kPlaceZ] = place.z();
  errors[kFocal] = rig.left.fx / truth.left.fx - 1;
  errors[kFocalRight] = rig.right.fx / truth.right.fx / (1 + errors[kFocal]) - 1;
  errors[kRowRight] = rig.right.cy - truth.right.cy;
  errors[kRangeOffset] = rig.range_offset_m - truth.range_offset_m;
  return errors;
}

}  // namespace sprout::calibrate
