#include "common/config/stage_parts.h"

namespace sprout {

PartSet InputsOf(const RefineConfig& config) {
  PartSet inputs{Part::kLeft, Part::kRight, Part::kTof, Part::kRig};
  if (config.zones()) inputs.Add(Part::kTofZones);
  return inputs;
}

PartSet OutputsOf(const RefineConfig&) { return {Part::kSeeds, Part::kLeftSeeds}; }

// LEFT also where no image is looked at: an answer has the pixels of an image that came, never as
// many as the few bytes of a calibration claim.
PartSet InputsOf(const PriorConfig& config) {
  PartSet inputs{Part::kSeeds, Part::kRig, Part::kLeft};
  if (config.left_seeds()) inputs.Add(Part::kLeftSeeds);
  if (config.method() == PriorConfig::EDGES) inputs.Add(Part::kRight);
  return inputs;
}

PartSet OutputsOf(const PriorConfig&) { return {Part::kPrior}; }

PartSet InputsOf(const GrowConfig& config) {
  PartSet inputs{Part::kLeft, Part::kRight, Part::kSeeds};
  if (config.similarity() == GrowConfig::EPC || config.fill() == GrowConfig::PRIOR) {
    inputs.Add(Part::kPrior);
  }
  return inputs;
}

PartSet OutputsOf(const GrowConfig& config) {
  PartSet outputs{Part::kDisparity};
  if (config.publish_unfilled()) outputs.Add(Part::kUnfilled);
  if (config.publish_confidence()) {
    outputs.Add(Part::kConfidence);
    outputs.Add(Part::kSigma);
  }
  return outputs;
}

PartSet InputsOf(const TemporalConfig& config) {
  PartSet inputs{Part::kLeft, Part::kRig, Part::kDisparity, Part::kConfidence};
  if (config.motion() == TemporalConfig::CHANNEL) inputs.Add(Part::kOdometry);
  return inputs;
}

PartSet OutputsOf(const TemporalConfig&) {
  return {Part::kFused, Part::kFusedConfidence, Part::kMotion};
}

PartSet InputsOf(std::string_view stage, const SproutConfig& config) {
  if (stage == "refine") return InputsOf(config.refine());
  if (stage == "prior") return InputsOf(config.prior());
  if (stage == "temporal") return InputsOf(config.temporal());
  return InputsOf(config.grow());
}

PartSet OutputsOf(std::string_view stage, const SproutConfig& config) {
  if (stage == "refine") return OutputsOf(config.refine());
  if (stage == "prior") return OutputsOf(config.prior());
  if (stage == "temporal") return OutputsOf(config.temporal());
  return OutputsOf(config.grow());
}

}  // namespace sprout
