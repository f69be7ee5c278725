#ifndef SPROUT_SERVICES_GROW_GROW_PLUG_H_
#define SPROUT_SERVICES_GROW_GROW_PLUG_H_

#include <string>
#include <vector>

#include "common/core/plug.h"
#include "services/grow/grower.h"

namespace sprout::grow {

/// LEFT RIGHT [SEEDS] [PRIOR] → DISPARITY [UNFILLED] [CONFIDENCE]: SEEDS when growth starts from
/// ToF seeds, PRIOR when the similarity is EPC or gaps take its disparities, UNFILLED and
/// CONFIDENCE when the configuration asks for them.
class GrowPlug : public Plug {
 public:
  explicit GrowPlug(const GrowConfig& config) : config_(config), grower_(config) {}

  PartSet Inputs() const override;

  /// Grow() and Finish(). Always answers; when nothing can grow the map is what gap filling makes
  /// of nothing (the prior, or no disparity), and the outcome says why. Images that do not fit
  /// together give no disparity.
  Outcome Process(const Frame& frame) override { return Finish(frame, Grow(frame)); }

  /// What grew.
  struct Growth {
    std::vector<Seed> seeds;  ///< that it started from
    DisparityImage map;       ///< of the left image's size
    bool refused = false;     ///< the images or the prior do not fit together
    std::string degenerate;   ///< why nothing grew; empty when something did
  };
  Growth Grow(const Frame& frame);

  /// Fills the gaps, and takes away what the confidence says is not sure.
  /// @param growth  of this frame.
  Outcome Finish(const Frame& frame, const Growth& growth) const;

 private:
  std::vector<Seed> SeedsOf(const Frame& frame, const cv::Mat1b& left,
                            const cv::Mat1b& right) const;

  GrowConfig config_;
  Grower grower_;
};

}  // namespace sprout::grow

#endif  // SPROUT_SERVICES_GROW_GROW_PLUG_H_
