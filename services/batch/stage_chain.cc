#include "services/batch/stage_chain.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

namespace sprout::batch {
namespace {

const StageNames kGraph = {"refine", "prior", "grow"};

}  // namespace

StageNames ParseStages(const std::string& flag, const std::vector<std::string>& names) {
  if (!names.empty() &&
      std::search(kGraph.begin(), kGraph.end(), names.begin(), names.end()) != kGraph.end()) {
    return names;
  }
  throw ConfigError(fmt::format(
      "{} {}: allowed are refine, prior and grow, one or several that follow each other", flag,
      fmt::join(names, ",")));
}

PartSet InputsOf(const std::string& stage, const SproutConfig& config) {
  if (stage == "refine") return {Part::kLeft, Part::kRight, Part::kTof, Part::kRig};
  if (stage == "prior") {
    PartSet inputs{Part::kSeeds, Part::kRig, Part::kLeft};
    if (config.prior().left_seeds()) inputs.Add(Part::kLeftSeeds);
    if (config.prior().method() == PriorConfig::EDGES) inputs.Add(Part::kRight);
    return inputs;
  }
  PartSet inputs{Part::kLeft, Part::kRight};
  const GrowConfig& grow = config.grow();
  if (grow.seeds() == GrowConfig::TOF) inputs.Add(Part::kSeeds);
  if (grow.similarity() == GrowConfig::EPC || grow.fill() == GrowConfig::PRIOR) {
    inputs.Add(Part::kPrior);
  }
  return inputs;
}

PartSet OutputsOf(const std::string& stage) {
  if (stage == "refine") return {Part::kSeeds, Part::kLeftSeeds};
  if (stage == "prior") return {Part::kPrior};
  return {Part::kUnfilled, Part::kDisparity, Part::kConfidence};
}

ChainInputs InputsOf(const StageNames& stages, const SproutConfig& config) {
  ChainInputs inputs{.first = InputsOf(stages.front(), config),
                     .all = InputsOf(stages.front(), config),
                     .first_has_all = true};
  PartSet answered = OutputsOf(stages.front());
  for (size_t i = 1; i < stages.size(); ++i) {
    const PartSet needed = InputsOf(stages[i], config);
    for (const Part part : kAllParts) {
      if (!needed.Has(part) || answered.Has(part)) continue;
      inputs.all.Add(part);
      inputs.first_has_all &= inputs.first.Has(part);
    }
    const PartSet outputs = OutputsOf(stages[i]);
    for (const Part part : kAllParts) {
      if (outputs.Has(part)) answered.Add(part);
    }
  }
  return inputs;
}

}  // namespace sprout::batch
