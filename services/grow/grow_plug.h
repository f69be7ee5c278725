#ifndef SPROUT_SERVICES_GROW_GROW_PLUG_H_
#define SPROUT_SERVICES_GROW_GROW_PLUG_H_

#include <vector>

#include "common/app/plug.h"
#include "services/grow/grower.h"

namespace sprout {

/// LEFT RIGHT [SEEDS] [PRIOR] → DISPARITY [UNFILLED] [CONFIDENCE]: SEEDS when growth starts from
/// ToF seeds, PRIOR when the similarity is EPC or gaps take its disparities, UNFILLED and
/// CONFIDENCE when the configuration asks for them.
class GrowPlug : public Plug {
 public:
  explicit GrowPlug(const GrowConfig& config) : config_(config), grower_(config) {}

  PartSet Inputs() const override;

  /// Always answers; when nothing can grow the map is what gap filling makes of nothing (the prior,
  /// or no disparity), and the outcome says why. Images that do not fit together give no disparity.
  Outcome Process(const Frame& frame) override;

 private:
  std::vector<Seed> SeedsOf(const Frame& frame, const cv::Mat1b& left,
                            const cv::Mat1b& right) const;

  GrowConfig config_;
  Grower grower_;
};

}  // namespace sprout

#endif  // SPROUT_SERVICES_GROW_GROW_PLUG_H_
