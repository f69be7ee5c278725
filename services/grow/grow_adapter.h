#pragma once

#include <string>
#include <vector>

#include "common/config/stage_parts.h"
#include "common/core/stage_adapter.h"
#include "services/grow/confidence/confidence.h"
#include "services/grow/fill/gap_filler.h"
#include "services/grow/grower.h"

namespace sprout::grow {

/// LEFT RIGHT SEEDS [PRIOR] → DISPARITY [UNFILLED] [CONFIDENCE SIGMA]: PRIOR when the similarity is
/// EPC or gaps take its disparities, the others when the configuration asks for them.
class GrowAdapter : public StageAdapter {
 public:
  explicit GrowAdapter(const GrowConfig& config) : config_(config), grower_(config) {}

  PartSet Inputs() const override { return InputsOf(config_); }

  /// Grow() and Finish(). Where seeds have negative disparities, in a wider frame (Widened()).
  /// Always answers; when nothing can grow, the map is what gap filling makes
  /// of an empty one (the prior, or no disparity), and the result says why. Images of different
  /// sizes give no disparity.
  StageResult Process(const Frame& frame) override { return Finish(frame, Grow(frame)); }

  /// The map before gap filling, and what it grew from.
  struct Growth {
    std::vector<Seed> seeds;    ///< that it started from
    DisparityImage map;         ///< of the left image's size
    bool is_unfit = false;      ///< the images or the prior do not fit together
    bool contradicted = false;  ///< seeds and prior are not of one scene: nothing is sure
    std::string degenerate;     ///< why nothing grew, or what does not fit together
    int columns = 0;            ///< of the frame that it grew in, see Widened()
    Frame wide = {};            ///< that frame, where columns > 0
  };
  Growth Grow(const Frame& frame);

  /// Fills the gaps, and removes disparities of low confidence.
  /// @param growth  of this frame.
  StageResult Finish(const Frame& frame, const Growth& growth);

 private:
  Growth GrowNonNegative(const Frame& frame);
  StageResult FinishNonNegative(const Frame& frame, const Growth& growth);
  ConfidenceEstimator::Judgement Judge(const Frame& frame, const Growth& growth,
                                       const DisparityImage& filled, std::string& doubt);

  GrowConfig config_;
  cv::Mat1b left_grey_, right_grey_;  // memory
  Grower grower_;
  GapFiller gap_filler_;
  ConfidenceEstimator confidence_;
};

}  // namespace sprout::grow
