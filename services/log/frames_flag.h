#ifndef SPROUT_SERVICES_LOG_FRAMES_FLAG_H_
#define SPROUT_SERVICES_LOG_FRAMES_FLAG_H_

#include <string>

#include "common/core/frame_range.h"

namespace sprout {

/// The value of --frames, see ParseFrameRange(); empty: all frames. @throws ConfigError.
FrameRange FramesFromFlag(const std::string& text);

}  // namespace sprout

#endif  // SPROUT_SERVICES_LOG_FRAMES_FLAG_H_
