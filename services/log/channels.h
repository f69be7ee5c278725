#ifndef SPROUT_SERVICES_LOG_CHANNELS_H_
#define SPROUT_SERVICES_LOG_CHANNELS_H_

#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>

#include "common/core/frame.h"
#include "common/messages/message_type.h"

namespace sprout::log {

/// The part that a channel of the graph with this prefix carries; nothing for other channels.
std::optional<Part> PartOfChannel(std::string_view channel, std::string_view prefix);

/// The type that a channel of ours must carry, whatever its prefix; nothing when the channel is
/// none of ours.
std::optional<MessageType> TypeOfChannel(std::string_view channel);

/// Which channels a subcommand looks at: those named, or all whose name begins with the prefix.
class ChannelFilter {
 public:
  /// @param names  without prefix; none: all.
  ChannelFilter(const std::vector<std::string>& names, std::string prefix);

  bool Has(std::string_view channel) const;

  const std::string& prefix() const { return prefix_; }
  const std::set<std::string, std::less<>>& names() const { return names_; }  ///< with prefix

 private:
  std::set<std::string, std::less<>> names_;
  std::string prefix_;
};

}  // namespace sprout::log

#endif  // SPROUT_SERVICES_LOG_CHANNELS_H_
