#include "services/pipeline/chain.h"

#include <utility>

#include "common/config/stage_parts.h"
#include "common/core/image.h"

namespace sprout {
namespace {

const SproutConfig& InRange(const SproutConfig& config) {
  RequireInRange(config, "");
  if (config.temporal().in_pipeline() && !config.grow().publish_confidence()) {
    throw ConfigError(
        "temporal.in_pipeline: true, but grow.publish_confidence is false; allowed: both true");
  }
  return config;
}

}  // namespace

Chain::Chain(const SproutConfig& config)
    : grows_with_prior_(InputsOf(InRange(config).grow()).Has(Part::kPrior)),
      refine_(config.refine()),
      prior_(config.prior()),
      grow_(config.grow()) {
  if (config.temporal().in_pipeline()) temporal_.emplace(config.temporal());
}

void Chain::Reset() {
  if (temporal_) temporal_->Reset();
}

ChainReport Chain::Run(Frame& frame, ChainObserver& observer, ChainStep last) {
  frame.left_grey = ToGrey(frame.left, left_grey_);  // once for all stages
  frame.right_grey = ToGrey(frame.right, right_grey_);
  ChainReport report = RunInGrey(frame, observer, last);
  // The memory is the chain's, or the caller's: "= {}" would fill it with zeros.
  frame.left_grey.release();
  frame.right_grey.release();
  return report;
}

ChainReport Chain::RunInGrey(Frame& frame, ChainObserver& observer, ChainStep last) {
  ChainReport report;
  const auto run = [&](ChainStep step, const auto& function) {
    observer.Begins(step);
    auto result = function();
    observer.Ended(step);
    return result;
  };
  const auto add = [&](const char* stage, StageResult outcome) {
    for (PartOutput& output : outcome.outputs) SetPart(frame, output.part, std::move(output.value));
    if (!outcome.degenerate.empty()) {
      report.warnings.push_back(std::string(stage) + ": " + outcome.degenerate);
    }
    observer.Answered(stage, frame, outcome);
  };
  if (!frame.seeds) {
    StageResult outcome = run(ChainStep::kRefine, [&] { return refine_.Process(frame); });
    report.tof_offset = outcome.tof_offset;
    report.range_error = outcome.finding;
    report.ranges_refused = outcome.ranges_refused;
    add("refine", std::move(outcome));
    observer.Refined(*frame.seeds, *frame.left_seeds);
  }
  if (last == ChainStep::kPrior || (grows_with_prior_ && last > ChainStep::kPrior)) {
    add("prior", run(ChainStep::kPrior, [&] { return prior_.Process(frame); }));
  }
  if (last < ChainStep::kGrow) return report;
  const auto growth = run(ChainStep::kGrow, [&] { return grow_.Grow(frame); });
  add("grow", run(ChainStep::kFinish, [&] { return grow_.Finish(frame, growth); }));
  if (temporal_ && last == ChainStep::kTemporal) {
    add("temporal", run(ChainStep::kTemporal, [&] { return temporal_->Process(frame); }));
  }
  return report;
}

}  // namespace sprout
