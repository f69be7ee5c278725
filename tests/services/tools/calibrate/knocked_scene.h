#pragma once

#include <cstdint>
#include <vector>

#include "common/scenes/synthetic_scene.h"
#include "services/tools/calibrate/board_view.h"
#include "services/tools/calibrate/scene/scene_refiner.h"

namespace sprout::calibrate {

/// SceneRig() without an error of the ranges.
RawRig TrueRig(cv::Size size);

/// Images of solids through the lenses of a rig; noise of 2 grey levels from the seed.
RigImages RenderSolids(const RawRig& rig, const std::vector<scenes::Solid>& solids, uint32_t seed,
                       bool with_tof);

/// The same of a synthetic scene.
/// @param frame  the scene's solids move from one to the next.
/// @param with_tof  a simulated SR4000, else none.
RigImages RenderScene(const RawRig& rig, uint32_t seed, int64_t frame, bool with_tof);

/// Refines a calibration that differs from the true one by `errors`, from such frames.
Result<SceneRefinement> RefineKnocked(const RawRig& rig, const RigNumbers& errors,
                                      const std::vector<RigImages>& frames,
                                      const SceneWishes& wishes = {});

/// The errors that remain: rig = Changed(truth, result).
RigNumbers ErrorsLeft(const RawRig& truth, const RawRig& rig);

}  // namespace sprout::calibrate
