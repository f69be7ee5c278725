#ifndef SPROUT_SERVICES_TOOLS_LOG_DIFFERENCE_PICTURES_H_
#define SPROUT_SERVICES_TOOLS_LOG_DIFFERENCE_PICTURES_H_

#include <cstdint>
#include <span>
#include <string>

#include "services/tools/log/log_frames.h"

namespace sprout::log {

/// Writes pictures of the difference of two messages of one channel and frame:
/// "000042_CHANNEL_a.png", "_b.png" and "_difference.png". Only for disparity maps, priors and
/// images of one size.
/// @throws std::runtime_error naming path and reason; ConfigError when the folder cannot be made.
void WriteDifferencePictures(std::span<const uint8_t> a, std::span<const uint8_t> b,
                             const std::string& channel, FrameFileNames& names);

}  // namespace sprout::log

#endif  // SPROUT_SERVICES_TOOLS_LOG_DIFFERENCE_PICTURES_H_
