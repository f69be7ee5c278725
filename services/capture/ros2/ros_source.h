#pragma once

#include <memory>
#include <stop_token>
#include <string>

#include "common/scenes/frame_source.h"
#include "services/capture/raw_source.h"
#include "services/capture/ros2/ros_input.h"

namespace sprout::capture {

struct RosSourceOptions {
  bool loop = false;             ///< start a file again at the end
  scenes::Waiting waiting = {};  ///< see FrameSource
  RosReports reports = {};
  std::stop_token stop = {};  ///< ends the wait for the calibration
};

/// Rectified frames of what a source ros2: or mcap: names: rectified images with their camera_info,
/// or raw ones with a rig file. Images belong together by their stamps (max_spread_ms). A point
/// cloud becomes a range image in the left camera's place (TofImageFromScan()), a depth image that
/// of a ToF camera. Waits up to 20 s for the calibration; a file must have it. When it changes
/// later, a frame has the new rig, and those that fit no calibration are lost.
/// @returns null when a stop was asked for.
/// @throws ConfigError naming what is missing or wrong.
std::unique_ptr<scenes::FrameSource> OpenRosSource(const std::string& source,
                                                   RosSourceOptions options);

/// Opens the images as the cameras see them, for --raw.
std::unique_ptr<RawSource> OpenRawRosSource(const std::string& source, RosSourceOptions options);

}  // namespace sprout::capture
