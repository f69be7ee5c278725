#ifndef SPROUT_SERVICES_TOOLS_LOG_CHANNELS_H_
#define SPROUT_SERVICES_TOOLS_LOG_CHANNELS_H_

#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace sprout::log {

/// The channels that a subcommand reads: those named, or all whose name begins with the prefix.
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

#endif  // SPROUT_SERVICES_TOOLS_LOG_CHANNELS_H_
