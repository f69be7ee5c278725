#include "services/tools/log/channels.h"

#include <utility>

namespace sprout::log {

ChannelFilter::ChannelFilter(const std::vector<std::string>& names, std::string prefix)
    : prefix_(std::move(prefix)) {
  for (const std::string& name : names) names_.insert(prefix_ + name);
}

bool ChannelFilter::Has(std::string_view channel) const {
  return names_.empty() ? channel.starts_with(prefix_) : names_.contains(channel);
}

}  // namespace sprout::log
