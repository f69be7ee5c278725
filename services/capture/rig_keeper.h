#pragma once

#include <chrono>
#include <filesystem>
#include <memory>
#include <string>

#include "common/config/config.h"
#include "common/core/rig_change.h"
#include "common/rig/raw_rig.h"
#include "services/capture/current_rig.h"

namespace sprout::capture {

/// Replaces the calibration in use by one with a change that sprout-selfcalibrate has seen
/// (self_calibrate { mode: APPLY }). Every calibration is in self_calibrate.folder before a frame
/// has it: rig_ID.textproto is the rig file of the frames with this rig_id.
class RigKeeper {
 public:
  using Clock = std::chrono::steady_clock;

  /// What became of a change.
  struct Outcome {
    bool used = false;
    std::string text;  ///< one line for people; empty: nothing was to be done
  };

  /// Writes the calibration that capture starts with.
  /// @throws ConfigError when the folder cannot be written, or the board's calibration in the rig
  ///         file cannot be used.
  RigKeeper(const SelfCalibrateConfig& config, std::shared_ptr<CurrentRig> current);

  /// Uses the change unless it is none (another verdict), is one of another calibration, comes too
  /// soon after the last one, or leads beyond the limits. Makes the new maps: O(pixels), some
  /// tenths of a second at 2 MP, so not for the thread that sends frames.
  Outcome Consider(const RigChange& change, Clock::time_point now);

 private:
  RigDescription Changed(const RawRig& rig) const;
  std::filesystem::path FileOf(const std::string& rig_id) const;

  SelfCalibrateConfig config_;
  std::shared_ptr<CurrentRig> current_;
  RawRig board_;
  Clock::time_point next_{};  // before this nothing is changed
};

}  // namespace sprout::capture
