#include "services/refine/refine_adapter.h"

#include <cmath>
#include <vector>

#include "common/core/image.h"
#include "services/inputs/check_inputs.h"

namespace sprout::refine {

// Rays are computed once a calibration.
const TofProjector& RefineAdapter::ProjectorOf(const Rig& rig) {
  const std::string rig_id = RigId(rig);
  if (!projector_ || projector_rig_id_ != rig_id) {
    projector_.emplace(rig);
    projector_rig_id_ = rig_id;
  }
  return *projector_;
}

Result<SeedSet> RefineAdapter::Refine(const Frame& frame) {
  const cv::Mat1b left = ToGrey(GreyestLeft(frame), left_grey_);
  const cv::Mat1b right = ToGrey(GreyestRight(frame), right_grey_);
  const TofZones zones = frame.tof_zones.value_or(TofZones());
  if (frame.tof->depth_m.empty()) {
    // Has no rays, so it is not worth keeping; the next frame may have an image again.
    const TofProjector no_camera(RigOfFrame(*frame.rig, *frame.tof));
    return refiner_.Compute(left, right, *frame.tof, no_camera, zones);
  }
  // Before there are rays for a ToF camera of whatever size a message claims.
  if (auto size = CheckTofSize(*frame.rig, *frame.tof); !size) {
    return tl::unexpected(size.error());
  }
  return refiner_.Compute(left, right, *frame.tof, ProjectorOf(*frame.rig), zones);
}

// What align_tof found, or else what there is to find in a frame that is looked at.
TofOffsetStatus RefineAdapter::OffsetOf(const Frame& frame, bool refined) {
  if (!refined || frame.tof->depth_m.empty()) return {};
  TofOffset offset = refiner_.tof_offset();
  if (!aligns_tof_) {
    if (check_tof_every_ == 0 || frame.id.seq % check_tof_every_ != 0) return {};
    const TofProjector& projector = ProjectorOf(*frame.rig);
    int behind = 0;
    const std::vector<ProjectedPoint> points = projector.Project(*frame.tof, behind);
    const cv::Mat1b left = ToGrey(GreyestLeft(frame), left_grey_);
    const cv::Mat1b right = ToGrey(GreyestRight(frame), right_grey_);
    offset = aligner_.Estimate(left, right, points, *frame.tof, projector);
  }
  if (!offset.sure) return {};
  return {.u_px = static_cast<float>(offset.du_px),
          .v_px = static_cast<float>(offset.dv_px),
          .sigma_px = static_cast<float>(std::hypot(offset.sigma_u_px, offset.sigma_v_px)),
          .is_off = !aligns_tof_ && offset.IsOff()};
}

// What is wrong with the input, in a frame that is looked at.
std::string RefineAdapter::WrongInput(const Frame& frame) {
  if (check_inputs_every_ == 0) return {};
  const bool has_tof = !frame.tof->depth_m.empty();
  const bool is_first = !has_checked_pair_ || (has_tof && !has_checked_tof_);
  if (!is_first && frame.id.seq % check_inputs_every_ != 0) return {};
  has_checked_pair_ = true;
  has_checked_tof_ = has_checked_tof_ || has_tof;
  return BadText(inputs::CheckInputs(
      ToGrey(GreyestLeft(frame), left_grey_), ToGrey(GreyestRight(frame), right_grey_), *frame.tof,
      frame.rig->pair, has_tof ? &ProjectorOf(*frame.rig) : nullptr));
}

StageResult RefineAdapter::Process(const Frame& frame) {
  Result<SeedSet> seeds = Refine(frame);
  SeedSet left_seeds = seeds ? refiner_.left_seeds() : SeedSet{};
  StageResult outcome;
  const bool refined = seeds.has_value();
  if (!refined) {
    outcome.degenerate = seeds.error().text;
    seeds = SeedSet{};
  } else if (seeds->seeds.empty()) {
    outcome.degenerate =
        seeds->raw == 0 ? "no ToF point has a return"
                        : "none of " + std::to_string(seeds->raw) + " ToF points became a seed";
    if (finds_stereo_seeds_) outcome.degenerate += ", and stereo found none";
  }
  const auto add = [&](const std::string& line) {
    if (!line.empty()) outcome.degenerate += (outcome.degenerate.empty() ? "" : "; ") + line;
  };
  if (refined) {
    add(WrongInput(frame));
    if (check_inputs_every_ > 0) add(range_watch_.Add(*frame.tof, *seeds, left_seeds));
  }
  outcome.tof_offset = OffsetOf(frame, refined);
  outcome.outputs.push_back({Part::kSeeds, std::move(*seeds)});
  outcome.outputs.push_back({Part::kLeftSeeds, std::move(left_seeds)});
  return outcome;
}

}  // namespace sprout::refine
