#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <stop_token>
#include <utility>
#include <vector>

#include "common/app/stage_monitor.h"
#include "common/config/config.h"
#include "common/core/frame.h"
#include "common/scenes/frame_source.h"
#include "services/capture/current_rig.h"

namespace sprout::capture {

/// One capture as messages for the bus.
struct CaptureMessages {
  FrameId id;
  std::vector<std::pair<Part, std::vector<uint8_t>>> messages;  ///< in the order of sending
};

/// When frames come.
enum class Timing {
  kAsked,     ///< whenever they are asked for: a dataset
  kLive,      ///< when the cameras give them
  kRecorded,  ///< whenever they are asked for; their utime gives the pace of recording
};

/// What capture sends: frames of a source, stamped at the call, or those of a log, with their
/// recorded times.
class CaptureFeed {
 public:
  virtual ~CaptureFeed() = default;

  /// The next capture; nothing when there are no more, or a stop was asked for.
  virtual std::optional<CaptureMessages> Next(const std::stop_token& stop) = 0;

  /// Message with the calibration of the newest frame; before the first, of the first. Empty when
  /// the frames are not rectified.
  virtual std::vector<uint8_t> Calibration() const = 0;

  virtual Timing timing() const = 0;

  /// At the end: whether the source was incomplete. No frame has a range image though there is a
  /// range sensor, most images of a recording became no frame, or parts of a log cannot be read.
  virtual bool lacks_something() const { return false; }

  /// The rig by which frames are rectified. It may be replaced at any time; the next frame has the
  /// new one. Null when the frames come rectified, or stay unrectified.
  virtual std::shared_ptr<CurrentRig> current_rig() const { return nullptr; }
};

struct FeedOptions {
  bool loop = false;             ///< start again at the end
  bool raw = false;              ///< unrectified frames of cameras, for channels with kRawPrefix
  scenes::Waiting waiting = {};  ///< called while Next() waits for cameras
  std::stop_token stop = {};     ///< ends a wait for cameras at the opening
};

/// Opens what config.source() names: log:FILE, cameras (OpenCameras()) or a dataset
/// (OpenDataset()). log:FILE?rig=RIG rectifies the raw images of a log with a rig file;
/// ?prefix=TEXT is before the log's channels.
/// @param monitor  counts losses and frames that cannot be sent; must outlive the feed.
/// @returns null when options.stop was requested while it waited for cameras.
/// @throws ConfigError naming what is missing or wrong, and where.
std::unique_ptr<CaptureFeed> OpenCaptureFeed(const CaptureConfig& config,
                                             const FeedOptions& options, StageMonitor& monitor);

}  // namespace sprout::capture
