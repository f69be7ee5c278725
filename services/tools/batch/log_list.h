#ifndef SPROUT_SERVICES_TOOLS_BATCH_LOG_LIST_H_
#define SPROUT_SERVICES_TOOLS_BATCH_LOG_LIST_H_

#include <filesystem>
#include <string>
#include <vector>

namespace sprout::batch {

/// The logs (*.lcm) in a folder and below: absolute paths, sorted. A file with several names (links
/// of either kind) is one log, by the first name that is no symbolic link where there is one.
/// @throws ConfigError when there is none.
std::vector<std::string> LogsBelow(const std::filesystem::path& folder);

/// The selected logs: absolute paths, without duplicates, in order.
struct FoundLogs {
  std::vector<std::string> logs;
  /// Those whose paths are not allowed in a manifest, as text for people (Printable()).
  std::vector<std::string> left_out;
};

/// @param inputs  logs, folders of logs, @LIST files with one of these a line.
/// @throws ConfigError for missing inputs, a list that contains itself, and when no log is left.
FoundLogs FindLogs(const std::vector<std::string>& inputs);

/// Why a log is left out; stands behind its name.
inline constexpr char kBadName[] =
    ": is not allowed in the manifest; allowed are names in UTF-8 without control characters";

}  // namespace sprout::batch

#endif  // SPROUT_SERVICES_TOOLS_BATCH_LOG_LIST_H_
