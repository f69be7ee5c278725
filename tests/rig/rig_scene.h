#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "common/rig/rectifier.h"
#include "common/scenes/lens_view.h"
#include "common/scenes/sr4000.h"
#include "common/scenes/synthetic_scene.h"
#include "services/tools/calibrate/board_view.h"

namespace sprout {

/// Sprout's synthetic scene as a rig sees it that is not rectified: through the lenses, from the
/// places and with the bias of the ranges that `rig` has. Same bytes at every call.
class RigScene {
 public:
  /// @param rig   with a ToF camera of the SR4000's size.
  /// @param seed  of the scene and of the noise.
  RigScene(const RawRig& rig, uint32_t seed);

  /// In colour, with a noise of 2 grey levels; the ToF image is the simulated SR4000's.
  /// @param step   of the scene.
  /// @param noise  other numbers, other noise.
  calibrate::RigImages Render(int64_t step, uint32_t noise) const;

  /// What the left image, once rectified by somebody's calibration, should have: at each pixel the
  /// disparity that the true depth has for that calibration's pair; NaN where the right camera
  /// does not see the surface. So an error of the calibration is one of the map.
  cv::Mat1f Truth(int64_t step, const Rectifier& rectifier) const;

 private:
  /// The image of a camera from its rays' colours.
  cv::Mat RenderImage(const scenes::LensView& view, const std::vector<scenes::Solid>& solids,
                      uint32_t noise) const;

  RawRig rig_;
  scenes::SyntheticScene scene_;
  scenes::LensView left_;
  scenes::LensView right_;
  scenes::LensView tof_;
  scenes::Sr4000 sr4000_;
  cv::Mat1d range_per_depth_;
};

}  // namespace sprout
