#ifndef SPROUT_COMMON_BUS_CHANNELS_H_
#define SPROUT_COMMON_BUS_CHANNELS_H_

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include "common/core/frame.h"

namespace sprout {

/// Before the channels of images as the cameras see them, behind the prefix of the graph.
inline constexpr std::string_view kRawPrefix = "RAW_";

/// Of SPROUT_STATUS, which is no part of a frame.
inline constexpr std::string_view kStatusChannel = "SPROUT_STATUS";

/// Of what a process is and how it is configured.
inline constexpr std::string_view kProcessChannel = "SPROUT_PROCESS";

/// Of pictures for people, in a type that is not ours.
inline constexpr std::string_view kPreviewChannel = "SPROUT_PREVIEW";

/// Every channel of the graph, without prefix, but for kPreviewChannel: no program of ours listens
/// to that.
inline std::vector<std::string_view> AllChannels() {
  std::vector<std::string_view> channels = {kStatusChannel, kProcessChannel};
  for (const Part part : kAllParts) channels.push_back(ChannelOf(part));
  return channels;
}

/// Longest prefix, characters: LCM allows 63 for prefix and channel.
inline constexpr size_t kMaxChannelPrefix = [] {
  size_t longest =
      std::max({kStatusChannel.size(), kProcessChannel.size(), kPreviewChannel.size()});
  for (const PartRow& row : kPartTable) longest = std::max(longest, row.channel.size());
  return 63 - longest;
}();

/// Whether a text may stand before every channel.
inline bool IsChannelPrefix(std::string_view prefix) {
  constexpr char kAllowed[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_-";
  return prefix.size() <= kMaxChannelPrefix &&
         prefix.find_first_not_of(kAllowed) == std::string_view::npos;
}

/// In words.
inline std::string AllowedChannelPrefix() {
  return "up to " + std::to_string(kMaxChannelPrefix) + " letters, digits, '_' and '-'";
}

}  // namespace sprout

#endif  // SPROUT_COMMON_BUS_CHANNELS_H_
