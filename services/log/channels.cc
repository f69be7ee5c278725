#include "services/log/channels.h"

#include <utility>

#include "common/bus/channels.h"

namespace sprout::log {

std::optional<Part> PartOfChannel(std::string_view channel, std::string_view prefix) {
  if (!channel.starts_with(prefix)) return std::nullopt;
  for (const Part part : kAllParts) {
    if (channel.substr(prefix.size()) == ChannelOf(part)) return part;
  }
  return std::nullopt;
}

std::optional<MessageType> TypeOfChannel(std::string_view channel) {
  if (channel.ends_with(kStatusChannel)) return MessageType::kStatus;
  if (channel.ends_with(kProcessChannel)) return MessageType::kProcess;
  for (const Part part : kAllParts) {
    if (channel.ends_with(ChannelOf(part))) return TypeOf(part);
  }
  return std::nullopt;
}

ChannelFilter::ChannelFilter(const std::vector<std::string>& names, std::string prefix)
    : prefix_(std::move(prefix)) {
  for (const std::string& name : names) names_.insert(prefix_ + name);
}

bool ChannelFilter::Has(std::string_view channel) const {
  return names_.empty() ? channel.starts_with(prefix_) : names_.contains(channel);
}

}  // namespace sprout::log
