#include "services/refine/refine_plug.h"

#include "common/core/image.h"

namespace sprout {

const TofProjector& RefinePlug::ProjectorOf(const Frame& frame) {
  if (!projector_ || projector_rig_id_ != frame.id.rig_id) {
    projector_.emplace(*frame.rig);
    projector_rig_id_ = frame.id.rig_id;
  }
  return *projector_;
}

Outcome RefinePlug::Process(const Frame& frame) {
  Result<SeedSet> seeds =
      refiner_.Compute(ToGrey(frame.left), ToGrey(frame.right), *frame.tof, ProjectorOf(frame));
  Outcome outcome;
  if (!seeds) {
    outcome.degenerate = seeds.error().text;
    seeds = SeedSet{};
  } else if (seeds->raw == 0) {
    outcome.degenerate = "no ToF point has a return";
  } else if (seeds->seeds.empty()) {
    outcome.degenerate = "none of " + std::to_string(seeds->raw) + " ToF points became a seed";
  }
  outcome.outputs.push_back({Part::kSeeds, std::move(*seeds)});
  return outcome;
}

}  // namespace sprout
