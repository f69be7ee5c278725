#include "services/batch/logs_below.h"

#include <sys/stat.h>

#include <algorithm>
#include <set>
#include <utility>

#include "common/config/config.h"

namespace sprout::batch {

std::vector<std::string> LogsBelow(const std::filesystem::path& folder) {
  namespace fs = std::filesystem;
  std::vector<std::pair<bool, std::string>> names;  // links last
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file() && entry.path().extension() == ".lcm") {
      names.emplace_back(entry.is_symlink(), fs::absolute(entry.path()).lexically_normal());
    }
  }
  std::sort(names.begin(), names.end());
  std::vector<std::string> logs;
  std::set<std::pair<dev_t, ino_t>> files;
  for (const auto& [is_link, name] : names) {
    struct stat status {};
    if (stat(name.c_str(), &status) != 0) continue;  // it has just been removed
    if (files.emplace(status.st_dev, status.st_ino).second) logs.push_back(name);
  }
  if (logs.empty()) throw ConfigError(folder.string() + ": no log (*.lcm) in this folder");
  std::sort(logs.begin(), logs.end());
  return logs;
}

}  // namespace sprout::batch
