#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <string_view>

namespace sprout {

/// How many events each channel of a log has; for messages about a missing channel.
class ChannelCounts {
 public:
  void Add(std::string_view channel) {
    const auto known = counts_.find(channel);
    if (known != counts_.end()) {
      ++known->second;
    } else {
      counts_.emplace(channel, 1);
    }
  }

  bool Has(std::string_view channel) const { return counts_.contains(channel); }

  /// "SPROUT_LEFT (20), SPROUT_RIG (2)", or "no events".
  std::string Text() const {
    std::string text;
    for (const auto& [channel, count] : counts_) {
      text += (text.empty() ? "" : ", ") + channel + " (" + std::to_string(count) + ")";
    }
    return text.empty() ? "no events" : text;
  }

 private:
  std::map<std::string, int64_t, std::less<>> counts_;
};

}  // namespace sprout
