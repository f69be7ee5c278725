#ifndef SPROUT_SERVICES_REFINE_REFINE_PLUG_H_
#define SPROUT_SERVICES_REFINE_REFINE_PLUG_H_

#include <optional>
#include <string>

#include "common/core/plug.h"
#include "services/refine/refiner.h"

namespace sprout::refine {

/// LEFT RIGHT TOF RIG → SEEDS LEFT_SEEDS.
class RefinePlug : public Plug {
 public:
  explicit RefinePlug(const RefineConfig& config)
      : refiner_(config),
        finds_stereo_seeds_(config.stereo_seeds()),
        aligns_tof_(config.align_tof()),
        check_tof_every_(config.check_tof_every()) {}

  PartSet Inputs() const override { return {Part::kLeft, Part::kRight, Part::kTof, Part::kRig}; }

  /// Always answers; without a usable point, and where stereo finds nothing either, both are empty
  /// and the outcome says why.
  Outcome Process(const Frame& frame) override;

 private:
  const TofProjector& ProjectorOf(const Rig& rig);
  Result<SeedSet> Refine(const Frame& frame);
  TofOffsetStatus OffsetOf(const Frame& frame, bool refined);

  Refiner refiner_;
  TofAligner aligner_;  // for frames that are only looked at
  bool finds_stereo_seeds_;
  bool aligns_tof_;
  int64_t check_tof_every_;
  cv::Mat1b left_grey_;  // memory
  cv::Mat1b right_grey_;
  std::optional<TofProjector> projector_;  // of the newest calibration
  std::string projector_rig_id_;
};

}  // namespace sprout::refine

#endif  // SPROUT_SERVICES_REFINE_REFINE_PLUG_H_
