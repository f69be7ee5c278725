#pragma once

#include <memory>
#include <string>

#include "common/rig/rig.pb.h"
#include "services/capture/raw_source.h"

namespace sprout::capture {

/// The cameras of a rig file, by GenICam: GigE Vision and USB3 Vision, through Aravis. Each camera
/// has a thread; Next() forms triplets by the time of exposure. utime is the middle of the
/// exposures of left and right, in the host's time (DeviceClock). Cameras may be lost and return:
/// without left or right Next() waits; without the ToF camera frames have an empty ToF image.
///
/// @param path     of the rig file, for messages.
/// @param waiting  called while Next() waits.
/// @throws ConfigError when the rig file names no cameras, or has unknown settings. Settings that a
///         camera refuses are reported in CapturedFrame::trouble and tried again.
std::unique_ptr<RawSource> OpenGenicam(const RigDescription& rig, const std::string& path,
                                       scenes::Waiting waiting = {});

/// For people, a line a camera: vendor, model, serial number, address, size and pixel formats, or
/// why these are unknown. Opens each camera briefly.
std::string ListCameras();

}  // namespace sprout::capture
