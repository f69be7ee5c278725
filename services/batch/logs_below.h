#ifndef SPROUT_SERVICES_BATCH_LOGS_BELOW_H_
#define SPROUT_SERVICES_BATCH_LOGS_BELOW_H_

#include <filesystem>
#include <string>
#include <vector>

namespace sprout::batch {

/// The logs (*.lcm) in a folder and below: absolute paths, sorted. A file with several names (links
/// of either kind) is one log, by the first name that is no symbolic link where there is one.
/// @throws ConfigError when there is none.
std::vector<std::string> LogsBelow(const std::filesystem::path& folder);

}  // namespace sprout::batch

#endif  // SPROUT_SERVICES_BATCH_LOGS_BELOW_H_
