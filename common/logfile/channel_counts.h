#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <string_view>

#include "common/core/joined.h"

namespace sprout {

/// How many events each channel of a log has; for messages about a missing channel.
class ChannelCounts {
 public:
  void Add(std::string_view channel) { ++counts_[std::string(channel)]; }

  bool Has(std::string_view channel) const { return counts_.contains(channel); }

  /// "SPROUT_LEFT (20), SPROUT_RIG (2)", or "no events".
  std::string Text() const {
    if (counts_.empty()) return "no events";
    return Joined(", ", counts_,
                  [](const auto& of) { return of.first + " (" + std::to_string(of.second) + ")"; });
  }

 private:
  std::map<std::string, int64_t, std::less<>> counts_;
};

}  // namespace sprout
