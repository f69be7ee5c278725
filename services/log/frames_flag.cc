#include "services/log/frames_flag.h"

#include "common/config/config.h"

namespace sprout {

FrameRange FramesFromFlag(const std::string& text) {
  if (text.empty()) return {};
  if (const auto frames = ParseFrameRange(text)) return *frames;
  throw ConfigError("--frames " + text +
                    ": no range of frames; allowed: A:B with 0 <= A <= B, A:, :B, A");
}

}  // namespace sprout
