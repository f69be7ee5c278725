#ifndef SPROUT_SERVICES_LOG_FRAME_PICTURES_H_
#define SPROUT_SERVICES_LOG_FRAME_PICTURES_H_

#include <cstdint>
#include <span>
#include <string>

#include "common/core/frame.h"
#include "services/log/log_frames.h"

namespace sprout::log {

/// Writes a picture of every part that the frame has and that can be shown.
/// @throws std::runtime_error naming path and reason; ConfigError when the folder cannot be made.
void WriteFramePictures(const Frame& frame, FrameFileNames& names);

/// Writes what differs between two messages of one channel and frame: "000042_CHANNEL_a.png",
/// "_b.png" and "_difference.png". Only of disparity maps, priors and images of one size; of others
/// nothing.
/// @throws as WriteFramePictures().
void WriteDifferencePictures(std::span<const uint8_t> a, std::span<const uint8_t> b,
                             const std::string& channel, FrameFileNames& names);

}  // namespace sprout::log

#endif  // SPROUT_SERVICES_LOG_FRAME_PICTURES_H_
