#pragma once

#include <string_view>

#include "common/config/config.h"
#include "common/core/frame.h"

namespace sprout {

// The chain in one place: which parts of a frame each stage needs and which it answers, by its
// configuration. For programs that run stages or prepare their inputs.

/// Parts that must be together before the stage can answer a frame.
PartSet InputsOf(const RefineConfig& config);
PartSet InputsOf(const PriorConfig& config);
PartSet InputsOf(const GrowConfig& config);
PartSet InputsOf(const TemporalConfig& config);

/// Parts that the stage adds to every frame that it answers.
PartSet OutputsOf(const RefineConfig& config);
PartSet OutputsOf(const PriorConfig& config);
PartSet OutputsOf(const GrowConfig& config);
PartSet OutputsOf(const TemporalConfig& config);

/// Inputs and outputs of the stage of this name.
/// @pre stage is "refine", "prior", "grow" or "temporal".
PartSet InputsOf(std::string_view stage, const SproutConfig& config);
PartSet OutputsOf(std::string_view stage, const SproutConfig& config);

}  // namespace sprout
