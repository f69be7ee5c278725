#include "services/batch/stage_chain.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "common/config/stage_parts.h"

namespace sprout::batch {
namespace {

const StageNames kGraph = {"refine", "prior", "grow", "temporal"};

}  // namespace

StageNames ParseStages(const std::string& flag, const std::vector<std::string>& names) {
  if (!names.empty() &&
      std::search(kGraph.begin(), kGraph.end(), names.begin(), names.end()) != kGraph.end()) {
    return names;
  }
  throw ConfigError(fmt::format(
      "{} {}: allowed are refine, prior, grow and temporal, one or several that follow each other",
      flag, fmt::join(names, ",")));
}

Part AnswerOf(const std::string& stage) {
  if (stage == "refine") return Part::kSeeds;
  if (stage == "prior") return Part::kPrior;
  return stage == "grow" ? Part::kDisparity : Part::kFused;
}

ChainInputs InputsOf(const StageNames& stages, const SproutConfig& config) {
  ChainInputs inputs{.first = InputsOf(stages.front(), config),
                     .all = InputsOf(stages.front(), config),
                     .first_has_all = true,
                     .has_memory = stages.back() == "temporal"};
  PartSet answered = OutputsOf(stages.front(), config);
  for (size_t i = 1; i < stages.size(); ++i) {
    const PartSet needed = InputsOf(stages[i], config);
    for (const Part part : kAllParts) {
      if (!needed.Has(part) || answered.Has(part)) continue;
      inputs.all.Add(part);
      inputs.first_has_all &= inputs.first.Has(part);
    }
    const PartSet outputs = OutputsOf(stages[i], config);
    for (const Part part : kAllParts) {
      if (outputs.Has(part)) answered.Add(part);
    }
  }
  return inputs;
}

}  // namespace sprout::batch
