#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/app/stage_monitor.h"
#include "common/config/config.h"
#include "common/core/stage_adapter.h"
#include "common/messages/convert.h"

namespace sprout {

/// A stage's answer to one frame, ready to be sent or recorded.
struct Answer {
  struct Message {
    std::string_view channel;  ///< without prefix
    std::vector<uint8_t> bytes;
  };
  std::vector<Message> messages;
  std::string degenerate;  ///< as in StageResult
  /// TofCoverage() of the seeds that the stage made or was given; kUnknownCoverage when it sees
  /// none.
  float tof_coverage = kUnknownCoverage;
  TofOffsetStatus tof_offset = {};
  std::optional<std::string> finding = {};  ///< as in StageResult
};

/// The encoding of disparity maps that the configuration chooses.
DisparityEncoding EncodingOf(const BusConfig& config);

/// Lets the adapter answer one frame; the same step live and replayed.
/// @returns nothing when the adapter failed (threw); that is counted, and the stage continues.
std::optional<Answer> MakeAnswer(const Frame& frame, StageAdapter& adapter,
                                 DisparityEncoding encoding, StageMonitor& monitor);

}  // namespace sprout
