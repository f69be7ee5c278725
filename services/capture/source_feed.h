#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/scenes/frame_source.h"
#include "services/capture/capture_feed.h"
#include "services/capture/raw_source.h"

namespace sprout::capture {

/// LEFT, RIGHT, TOF and, with a multi-zone sensor, TOF_ZONES of a frame, as a feed sends them.
CaptureMessages Encoded(const FrameId& id, const scenes::CapturedFrame& frame);

/// A frame with its calibration in front, for one whose calibration is new.
CaptureMessages BehindCalibration(std::vector<uint8_t> calibration, CaptureMessages frame);

/// Frames of a source, numbered from 0 and stamped with their time of exposure, or, when the source
/// has no clock, with the time at which they are taken: the only place where a clock enters a
/// payload. Times of frames increase until a recording begins again, or the clock is set back by
/// more than a second; any clock that was set back is warned of.
/// @param rig  what the source rectifies with; null when its frames come rectified.
/// @param now  returns the time, as NowUtime(); tests replace it.
std::unique_ptr<CaptureFeed> FeedFrom(std::unique_ptr<scenes::FrameSource> source,
                                      const CaptureConfig& config, StageMonitor& monitor,
                                      std::shared_ptr<CurrentRig> rig = nullptr,
                                      std::function<int64_t()> now = NowUtime);

/// Unrectified frames of cameras, for --raw; they have no rig_id.
std::unique_ptr<CaptureFeed> RawFeedFrom(std::unique_ptr<RawSource> cameras,
                                         const CaptureConfig& config, StageMonitor& monitor);

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
