#ifndef SPROUT_COMMON_BUS_CHANNELS_H_
#define SPROUT_COMMON_BUS_CHANNELS_H_

#include <string>
#include <string_view>
#include <vector>

#include "common/core/frame.h"

namespace sprout {

/// The channel of a part, without prefix. The only place that names channels.
constexpr std::string_view ChannelOf(Part part) {
  switch (part) {
    case Part::kLeft:
      return "SPROUT_LEFT";
    case Part::kRight:
      return "SPROUT_RIGHT";
    case Part::kTof:
      return "SPROUT_TOF";
    case Part::kRig:
      return "SPROUT_RIG";
    case Part::kSeeds:
      return "SPROUT_SEEDS";
    case Part::kLeftSeeds:
      return "SPROUT_LEFT_SEEDS";
    case Part::kPrior:
      return "SPROUT_PRIOR";
    case Part::kUnfilled:
      return "SPROUT_UNFILLED";
    case Part::kDisparity:
      return "SPROUT_DISPARITY";
    case Part::kConfidence:
      return "SPROUT_CONFIDENCE";
  }
  return {};
}

inline constexpr std::string_view kStatusChannel = "SPROUT_STATUS";

/// Every channel of the graph, without prefix.
inline std::vector<std::string_view> AllChannels() {
  std::vector<std::string_view> channels = {kStatusChannel};
  for (const Part part : kAllParts) channels.push_back(ChannelOf(part));
  return channels;
}

/// Longest prefix, characters: LCM allows 63 for prefix and channel.
inline constexpr size_t kMaxChannelPrefix = 63 - std::string_view("SPROUT_CONFIDENCE").size();

}  // namespace sprout

#endif  // SPROUT_COMMON_BUS_CHANNELS_H_
