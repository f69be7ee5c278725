#include "services/refine/refine_plug.h"

#include "common/core/image.h"

namespace sprout {

// Rays are computed once a calibration.
const TofProjector& RefinePlug::ProjectorOf(const Rig& rig) {
  const std::string rig_id = RigId(rig);
  if (!projector_ || projector_rig_id_ != rig_id) {
    projector_.emplace(rig);
    projector_rig_id_ = rig_id;
  }
  return *projector_;
}

Result<SeedSet> RefinePlug::Refine(const Frame& frame) {
  const cv::Mat1b left = ToGrey(frame.left, left_grey_);
  const cv::Mat1b right = ToGrey(frame.right, right_grey_);
  if (frame.tof->depth_m.empty()) {
    // Has no rays, so it is not worth keeping; the next frame may have an image again.
    const TofProjector no_camera(RigOfFrame(*frame.rig, *frame.tof));
    return refiner_.Compute(left, right, *frame.tof, no_camera);
  }
  // Before there are rays for a ToF camera of whatever size a message claims.
  if (auto size = CheckTofSize(*frame.rig, *frame.tof); !size) {
    return tl::unexpected(size.error());
  }
  return refiner_.Compute(left, right, *frame.tof, ProjectorOf(*frame.rig));
}

Outcome RefinePlug::Process(const Frame& frame) {
  Result<SeedSet> seeds = Refine(frame);
  SeedSet left_seeds = seeds ? refiner_.left_seeds() : SeedSet{};
  Outcome outcome;
  if (!seeds) {
    outcome.degenerate = seeds.error().text;
    seeds = SeedSet{};
  } else if (seeds->seeds.empty()) {
    outcome.degenerate =
        seeds->raw == 0 ? "no ToF point has a return"
                        : "none of " + std::to_string(seeds->raw) + " ToF points became a seed";
    if (finds_stereo_seeds_) outcome.degenerate += ", and stereo found none";
  }
  outcome.outputs.push_back({Part::kSeeds, std::move(*seeds)});
  outcome.outputs.push_back({Part::kLeftSeeds, std::move(left_seeds)});
  return outcome;
}

}  // namespace sprout
