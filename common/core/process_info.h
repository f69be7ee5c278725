#pragma once

#include <cstdint>
#include <string>

#include "common/core/frame_id.h"

namespace sprout {

/// What a process is and how it is configured; field by field as in lcmtypes/process_info_t.lcm.
struct ProcessInfo {
  FrameId header;  ///< no frame: seq = −1
  std::string stage;
  std::string host;  ///< empty on a replay
  std::string version;
  std::string config_digest;  ///< of config_text
  std::string config_text;    ///< as ConfigText()
  int32_t pid = 0;            ///< 0 on a replay

  bool operator==(const ProcessInfo&) const = default;
};

}  // namespace sprout
