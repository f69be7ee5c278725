#ifndef SPROUT_SERVICES_CAPTURE_CAPTURE_FEED_H_
#define SPROUT_SERVICES_CAPTURE_CAPTURE_FEED_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "common/app/stage_monitor.h"
#include "common/config/config.h"
#include "common/core/frame.h"

namespace sprout {

/// One capture as it goes on the bus.
struct CaptureMessages {
  FrameId id;
  std::vector<std::pair<Part, std::vector<uint8_t>>> messages;  ///< in the order of sending
};

/// What capture sends: frames of a source, taken at the call, or those of a log, taken once.
class CaptureFeed {
 public:
  virtual ~CaptureFeed() = default;

  /// The next capture; nothing when there are no more.
  virtual std::optional<CaptureMessages> Next() = 0;

  /// Message with the calibration of the newest frame; before the first, of the first.
  virtual std::vector<uint8_t> Calibration() const = 0;

  /// Whether the frames' utime tells at what pace they once came.
  virtual bool is_recorded() const = 0;
};

/// Opens what config.source() names: log:FILE, or a Dataset.
/// @param loop     start again at the end.
/// @param monitor  is told what cannot be sent; must outlive the feed.
/// @throws ConfigError naming what is missing or wrong, and where.
std::unique_ptr<CaptureFeed> OpenCaptureFeed(const CaptureConfig& config, bool loop,
                                             StageMonitor& monitor);

}  // namespace sprout

#endif  // SPROUT_SERVICES_CAPTURE_CAPTURE_FEED_H_
