#pragma once

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include "common/core/frame.h"

namespace sprout {

/// Prefix of the channels of raw images (as the cameras see them), after the prefix of the graph.
inline constexpr std::string_view kRawPrefix = "RAW_";

/// Channel of statuses, which are no part of a frame.
inline constexpr std::string_view kStatusChannel = "SPROUT_STATUS";

/// Channel of what a process is and how it is configured.
inline constexpr std::string_view kProcessChannel = "SPROUT_PROCESS";

/// Channel of what self-calibration sees, which is no part of a frame: of many.
inline constexpr std::string_view kRigChangeChannel = "SPROUT_RIG_CHANGE";

/// Whether every message of a channel fits one datagram, whatever its prefix.
inline constexpr bool IsShort(std::string_view channel) {
  return channel == kStatusChannel || channel == kRigChangeChannel;
}

/// Channel of preview pictures for people, in a type of other LCM tools (bot_core.image_t).
inline constexpr std::string_view kPreviewChannel = "SPROUT_PREVIEW";

/// Channel of laser scans, in a type of other LCM tools (bot_core.planar_lidar_t).
inline constexpr std::string_view kScanChannel = "SPROUT_SCAN";

/// Every channel of the graph, without prefix, except kPreviewChannel and kScanChannel, which no
/// Sprout program subscribes to.
inline std::vector<std::string_view> AllChannels() {
  std::vector<std::string_view> channels = {kStatusChannel, kProcessChannel, kRigChangeChannel};
  for (const Part part : kAllParts) channels.push_back(ChannelOf(part));
  return channels;
}

/// Longest prefix, characters: LCM allows 63 for prefix and channel.
inline constexpr size_t kMaxChannelPrefix = [] {
  size_t longest =
      std::max({kStatusChannel.size(), kProcessChannel.size(), kRigChangeChannel.size(),
                kPreviewChannel.size(), kScanChannel.size()});
  for (const PartRow& row : kPartTable) longest = std::max(longest, row.channel.size());
  return 63 - longest;
}();

/// Whether a text may be the prefix of all channels.
inline bool IsChannelPrefix(std::string_view prefix) {
  constexpr char kAllowed[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_-";
  return prefix.size() <= kMaxChannelPrefix &&
         prefix.find_first_not_of(kAllowed) == std::string_view::npos;
}

/// The rule for prefixes, for error messages.
inline std::string AllowedChannelPrefix() {
  return "up to " + std::to_string(kMaxChannelPrefix) + " letters, digits, '_' and '-'";
}

}  // namespace sprout
