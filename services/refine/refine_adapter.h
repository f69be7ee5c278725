#pragma once

#include <array>
#include <optional>
#include <string>
#include <utility>

#include "common/config/stage_parts.h"
#include "common/core/stage_adapter.h"
#include "common/inputs/hang_watch.h"
#include "common/inputs/range_watch.h"
#include "services/refine/refiner.h"

namespace sprout::refine {

/// LEFT RIGHT TOF RIG, with `zones` TOF_ZONES → SEEDS LEFT_SEEDS.
class RefineAdapter : public StageAdapter {
 public:
  explicit RefineAdapter(const RefineConfig& config)
      : config_(config),
        inputs_(InputsOf(config)),
        refiner_(config),
        finds_stereo_seeds_(config.stereo_seeds()),
        aligns_tof_(config.align_tof()),
        check_tof_every_(config.check_tof_every()),
        check_inputs_every_(config.check_inputs_every()),
        unambiguous_range_m_(config.unambiguous_range_m()) {}

  PartSet Inputs() const override { return inputs_; }

  /// Always answers. If there is no usable point, and stereo finds nothing either, both outputs are
  /// empty and the result says why. It also says when range points stop to come, when a sensor
  /// hangs, and what is wrong with the input: that is checked in the first frame of a calibration,
  /// its first with a range image, and one of check_inputs_every, and told again in later frames
  /// that have no seeds or whose points are not believed.
  ///
  /// A range image that was enlarged is taken at its sensor's resolution, see FindNativeRanges().
  /// Where disparities may be negative (cx_right > cx), and range points or a coarse match have
  /// such, the frame is also refined in a wider one (Widened()). That answer is taken if one seed
  /// in a hundred is negative and there are as many seeds.
  StageResult Process(const Frame& frame) override;

 private:
  struct Refined {
    StageResult answer;
    bool fits = true;  // whether images and range image have the sizes of the calibration
  };

  // Says which frames a costly check looks at.
  class CheckSchedule {
   public:
    // Whether a frame is the first of a calibration, or the first of `every` frame numbers that was
    // not skipped under load.
    bool IsDue(const FrameId& id, int64_t every) {
      const std::pair turn(id.rig_id, id.seq / every);
      return std::exchange(newest_, turn) != turn;
    }

   private:
    std::optional<std::pair<std::string, int64_t>> newest_;
  };

  bool HasPointsBelowZero(const Frame& frame, double share);
  StageResult ProcessNative(const Frame& frame);
  Refined RefineAnySign(const Frame& frame);
  Refined RefineNonNegative(const Frame& frame);
  const TofProjector& ProjectorOf(const Rig& rig);
  Result<SeedSet> Refine(const Frame& frame);
  TofOffsetStatus OffsetOf(const Frame& frame);
  bool CheckInput(const Frame& frame);

  RefineConfig config_;
  PartSet inputs_;
  Refiner refiner_;
  TofAligner aligner_;  // for frames that are only looked at
  bool finds_stereo_seeds_;
  bool aligns_tof_;
  int64_t check_tof_every_;
  int64_t check_inputs_every_;
  double unambiguous_range_m_;
  CheckSchedule pose_checks_;
  CheckSchedule pair_checks_;
  CheckSchedule tof_checks_;
  std::string wrong_input_;  // by the newest check
  inputs::RangeWatch range_watch_;
  inputs::HangWatch hang_watch_;
  cv::Mat1b left_grey_;  // memory
  cv::Mat1b right_grey_;
  // The projectors of the newest calibration: for the left image, and for a wider frame around it.
  struct KeptProjector {
    std::string rig_id;
    std::optional<TofProjector> projector;
  };
  std::array<KeptProjector, 2> projectors_;
};

}  // namespace sprout::refine
