#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "common/logfile/log_reader.h"

namespace sprout {

/// Bytes of messages by channel, in their order.
using ChannelBytes = std::map<std::string, std::vector<std::vector<uint8_t>>>;

/// What a log holds that may still be written.
inline ChannelBytes ReadChannels(const std::filesystem::path& log) {
  ChannelBytes channels;
  LogReader reader(log);
  LogEvent event;
  while (reader.Next(event)) {
    channels[std::string(event.channel)].emplace_back(event.data.begin(), event.data.end());
  }
  return channels;
}

inline const std::filesystem::path kSampleLog =
    std::filesystem::path(SPROUT_SOURCE_DIR) / "logs" / "sample.lcm";

}  // namespace sprout
