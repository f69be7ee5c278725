#include "services/pipeline/pipeline_adapter.h"

#include <string>
#include <string_view>
#include <vector>

#include "common/config/stage_parts.h"
#include "common/core/joined.h"

namespace sprout {
namespace {

PartSet AllInputs(const SproutConfig& config) {
  PartSet inputs = InputsOf(config.refine());
  if (config.temporal().in_pipeline() && InputsOf(config.temporal()).Has(Part::kOdometry)) {
    inputs.Add(Part::kOdometry);
  }
  return inputs;
}

PartSet AllOutputs(const SproutConfig& config) {
  PartSet outputs;
  for (const char* stage : {"refine", "prior", "grow", "temporal"}) {
    if (stage == std::string_view("temporal") && !config.temporal().in_pipeline()) continue;
    const PartSet of_stage = OutputsOf(stage, config);
    for (const Part part : kAllParts) {
      if (of_stage.Has(part)) outputs.Add(part);
    }
  }
  return outputs;
}

}  // namespace

PipelineAdapter::PipelineAdapter(const SproutConfig& config, ChainObserver& steps)
    : steps_(steps),
      inputs_(AllInputs(config)),
      outputs_(AllOutputs(config)),
      grows_with_prior_(InputsOf(config.grow()).Has(Part::kPrior)),
      warm_up_frames_(config.temporal().in_pipeline() ? config.temporal().warm_up_frames() : 0),
      chain_(config) {}

PartSet PipelineAdapter::Inputs() const { return inputs_; }

StageResult PipelineAdapter::Process(const Frame& frame) {
  Frame work = frame;  // shares the images' pixels
  std::vector<std::string> warnings = chain_.Run(work, steps_).warnings;
  if (!grows_with_prior_) {
    // Like sprout-prior, which answers also where growth does not use its map.
    const ChainReport prior = chain_.Run(work, steps_, ChainStep::kPrior);
    warnings.insert(warnings.end(), prior.warnings.begin(), prior.warnings.end());
  }
  StageResult outcome{.outputs = {}, .degenerate = Joined("; ", warnings)};
  for (const Part part : kAllParts) {
    if (outputs_.Has(part)) outcome.outputs.push_back({part, GetPart(work, part)});
  }
  return outcome;
}

}  // namespace sprout
