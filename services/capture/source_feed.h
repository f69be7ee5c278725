#ifndef SPROUT_SERVICES_CAPTURE_SOURCE_FEED_H_
#define SPROUT_SERVICES_CAPTURE_SOURCE_FEED_H_

#include <memory>
#include <vector>

#include "common/scenes/frame_source.h"
#include "services/capture/capture_feed.h"
#include "services/capture/raw_source.h"

namespace sprout::capture {

/// LEFT, RIGHT, TOF and, with a multi-zone sensor, TOF_ZONES of a frame, as a feed sends them.
CaptureMessages Encoded(const FrameId& id, const scenes::CapturedFrame& frame);

/// A frame whose calibration is a new one: that is sent before it.
CaptureMessages BehindCalibration(std::vector<uint8_t> calibration, CaptureMessages frame);

/// Frames of a source, numbered from 0 and stamped with their time of exposure, or, when the source
/// has no clock, with the time at which they are taken: the only place where a clock enters a
/// payload. Times of frames increase, whatever the clock does.
/// @param rig  what the source rectifies with; null when its frames come rectified.
std::unique_ptr<CaptureFeed> FeedFrom(std::unique_ptr<scenes::FrameSource> source,
                                      const CaptureConfig& config, StageMonitor& monitor,
                                      std::shared_ptr<CurrentRig> rig = nullptr);

/// Frames of cameras as they see, for --raw; the frames have no rig_id.
std::unique_ptr<CaptureFeed> FeedFrom(std::unique_ptr<RawSource> cameras,
                                      const CaptureConfig& config, StageMonitor& monitor);

}  // namespace sprout::capture

#endif  // SPROUT_SERVICES_CAPTURE_SOURCE_FEED_H_
