#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/config/config.h"
#include "common/core/frame.h"
#include "services/grow/grow_adapter.h"
#include "services/prior/prior_adapter.h"
#include "services/refine/refine_adapter.h"
#include "services/temporal/temporal_adapter.h"

namespace sprout {

/// The steps of the chain, in their order. kFinish: gap filling, and the confidence where the
/// configuration asks for it. kTemporal: only with temporal.in_pipeline.
enum class ChainStep { kRefine, kPrior, kGrow, kFinish, kTemporal };

/// Observes a chain at work, to time its steps or to add noise to its seeds.
class ChainObserver {
 public:
  virtual ~ChainObserver() = default;
  virtual void Begins(ChainStep /*step*/) {}
  virtual void Ended(ChainStep /*step*/) {}
  /// The stage "refine", "prior", "grow" or "temporal" has answered, and the frame has what it
  /// gave.
  /// @param outcome  its result without the parts, which have been moved into the frame.
  virtual void Answered(std::string_view /*stage*/, const Frame& /*frame*/,
                        const StageResult& /*outcome*/) {}
  /// The frame's seeds, before prior and growth use them; they may be changed.
  virtual void Refined(SeedSet& /*seeds*/, SeedSet& /*left_seeds*/) {}
};

/// What a chain reports about a frame, beside its parts.
struct ChainReport {
  /// Why a stage had nothing to give ("refine: no ToF point has a return"), one line each; empty
  /// when all is well.
  std::vector<std::string> warnings;
  TofOffsetStatus tof_offset;              ///< see StageResult
  std::optional<std::string> range_error;  ///< StageResult::finding of refine
  bool ranges_refused = false;             ///< see StageResult
};

/// refine, prior and grow on one frame, and with temporal.in_pipeline temporal on the frames since
/// the newest reset, as the services of these names compute it, to the byte. The one place that
/// knows their order. Keeps its memory from frame to frame, so one object serves one caller at a
/// time.
class Chain {
 public:
  /// @throws ConfigError naming the first value that is out of range, or temporal.in_pipeline
  ///         without grow.publish_confidence.
  explicit Chain(const SproutConfig& config);

  /// Adds SEEDS and LEFT_SEEDS, PRIOR when growth uses it, DISPARITY, and other parts that the
  /// configuration asks for.
  /// @param frame     has LEFT, RIGHT, TOF and RIG that fit each other, for kTemporal also an id.
  ///                  When it has SEEDS already, refinement is left out.
  /// @param last      later steps are left out; with kPrior the prior is always made.
  ChainReport Run(Frame& frame, ChainObserver& observer, ChainStep last = ChainStep::kTemporal);

  /// Forgets all frames.
  void Reset();

 private:
  ChainReport RunInGrey(Frame& frame, ChainObserver& observer, ChainStep last);

  bool grows_with_prior_;
  cv::Mat1b left_grey_, right_grey_;  // memory
  refine::RefineAdapter refine_;
  prior::PriorAdapter prior_;
  grow::GrowAdapter grow_;
  std::optional<temporal::TemporalAdapter> temporal_;  // where the configuration asks for it
};

}  // namespace sprout
