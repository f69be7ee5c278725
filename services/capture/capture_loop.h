#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/app/service_context.h"

namespace sprout::capture {

/// How frames are sent; the source and its settings are in CaptureConfig.
struct CaptureOptions {
  std::optional<int64_t> frames;   ///< stop after this many; nothing: when the source ends
  bool loop = false;               ///< start the source again when it ends
  bool raw = false;                ///< see FeedOptions
  bool rate_is_asked_for = false;  ///< set by a flag; a log ignores the configured rate
  /// Frames that may be without a SPROUT_DISPARITY answer; nothing: send without waiting.
  std::optional<int> lockstep;
  double lockstep_timeout_s = 10;     ///< after which a frame is sent again
  std::vector<std::string> wait_for;  ///< stages that must report before the first frame
  double wait_timeout_s = 30;         ///< how long to wait for them
};

/// Sends the source's frames on LEFT, RIGHT and TOF (raw ones with kRawPrefix before them), and the
/// calibration on RIG at start and once a second, until the source ends or context.stop.
/// @returns exit code: 0; 1 when a stage does not report in time.
/// @throws ConfigError when the source cannot be used; BusError when the network cannot.
int RunCapture(const ServiceContext& context, const CaptureOptions& options);

}  // namespace sprout::capture
