#ifndef SPROUT_SERVICES_CAPTURE_LOG_FEED_H_
#define SPROUT_SERVICES_CAPTURE_LOG_FEED_H_

#include <memory>
#include <string>

#include "services/capture/capture_feed.h"

namespace sprout::capture {

/// LEFT, RIGHT, TOF and RIG of a log, byte for byte as recorded, with their own utime and seq. A
/// frame with a missing or refused message is counted and not sent: no stage could answer it.
/// Constant memory: some frames, whatever the log's size.
///
/// @param prefix  before the channels in the log.
/// @throws ConfigError when the file is no log, or has no complete frame or no calibration.
std::unique_ptr<CaptureFeed> OpenLogFeed(const std::string& path, const std::string& prefix,
                                         bool loop, StageMonitor& monitor);

/// The raw images of a log (kRawPrefix after `prefix`), each rectified with the rig that is current
/// when it is read; a calibration in the log is ignored. A frame of another size than the
/// calibrated one is counted and not sent.
std::unique_ptr<CaptureFeed> OpenRawLogFeed(const std::string& path, const std::string& prefix,
                                            std::shared_ptr<CurrentRig> rig, bool loop,
                                            StageMonitor& monitor);

}  // namespace sprout::capture

#endif  // SPROUT_SERVICES_CAPTURE_LOG_FEED_H_
