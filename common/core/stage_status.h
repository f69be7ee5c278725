#pragma once

#include <cmath>
#include <cstdint>
#include <string>

#include "common/core/frame_id.h"
#include "common/core/tof_coverage.h"

namespace sprout {

/// Median, high percentiles and maximum of a time, ms.
struct TimeSummary {
  double p50_ms = 0;
  double p95_ms = 0;
  double p99_ms = 0;
  double max_ms = 0;
};

/// The offset to add to the ToF camera's points in the middle of the left image.
struct TofOffsetStatus {
  float u_px = 0;
  float v_px = 0;
  float sigma_px = -1;  ///< standard deviation; −1 = not known
  bool is_off = false;  ///< the offset is sure and significant; not sent

  /// Whether it is more than what is measured where there is none. With three standard deviations
  /// one in a hundred of those would be shown (two directions, e^(−3²/2)).
  bool IsSignificant() const {
    constexpr float kStandardDeviations = 3;
    return sigma_px >= 0 && std::hypot(u_px, v_px) > kStandardDeviations * sigma_px;
  }
};

/// State of one process; field by field as in lcmtypes/stage_status_t.lcm.
struct StageStatus {
  enum class State { kReady = 0, kRunning = 1, kStopped = 2 };

  FrameId newest_frame;  ///< seq = −1: none yet
  std::string stage;
  std::string host;
  std::string version;
  std::string config_digest;
  std::string last_error;  ///< empty = no error yet, or it is over
  int32_t pid = 0;
  State state = State::kReady;
  int64_t frames_in = 0;
  int64_t frames_out = 0;
  int64_t frames_skipped = 0;
  int64_t frames_incomplete = 0;
  int64_t frames_degenerate = 0;
  int64_t frames_failed = 0;
  int64_t frames_resent = 0;
  int64_t bad_messages = 0;
  int64_t sequence_gaps = 0;
  double rate_hz = 0;
  TimeSummary latency;  ///< complete frame received to answer published
  TimeSummary age;      ///< capture to answer published
  int64_t rss_bytes = 0;
  /// TofCoverage() of the newest frame.
  float tof_coverage = kUnknownCoverage;
  /// Time between the exposures of the newest frame's images, ms; −1 = not known.
  float spread_ms = -1;
  TofOffsetStatus tof_offset;
};

}  // namespace sprout
