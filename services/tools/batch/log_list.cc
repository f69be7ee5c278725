#include "services/tools/batch/log_list.h"

#include <sys/stat.h>

#include <algorithm>
#include <fstream>
#include <set>
#include <utility>

#include "common/config/config_error.h"
#include "common/core/input_files.h"
#include "common/core/printable.h"
#include "services/tools/batch/names.h"

namespace sprout::batch {
namespace {

namespace fs = std::filesystem;

// Follows what was asked for, lists in lists too.
class Inputs {
 public:
  void Add(const std::string& input) {
    if (input.starts_with('@')) {
      AddList(input.substr(1));
    } else if (fs::is_directory(input)) {
      const std::vector<std::string> found = LogsBelow(input);
      logs_.insert(logs_.end(), found.begin(), found.end());
    } else if (fs::is_regular_file(input)) {
      logs_.push_back(fs::absolute(input).lexically_normal());
    } else {
      throw ConfigError(Printable(input) + ": no such log or folder");
    }
  }

  const std::vector<std::string>& logs() const { return logs_; }

 private:
  void AddList(const std::string& path) {
    NoteInputFile(path);
    std::ifstream list(path);
    // A pipe is as good as a file; others, such as /dev/zero, may never end.
    if (!list || !(fs::is_regular_file(path) || fs::is_fifo(path))) {
      throw ConfigError("@" + Printable(path) +
                        ": no such list; allowed: a text file, a log a line");
    }
    const fs::path canonical = fs::canonical(path);
    if (std::ranges::count(open_, canonical) > 0) {
      throw ConfigError("@" + Printable(path) + ": the list contains itself");
    }
    open_.push_back(canonical);
    for (std::string line; std::getline(list, line);) {
      if (!line.empty()) Add(line);
    }
    open_.pop_back();
  }

  std::vector<std::string> logs_;
  std::vector<fs::path> open_;  // lists being read, each inside the one before
};

}  // namespace

std::vector<std::string> LogsBelow(const fs::path& folder) {
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

FoundLogs FindLogs(const std::vector<std::string>& inputs) {
  Inputs all;
  for (const std::string& input : inputs) all.Add(input);
  FoundLogs found;
  std::set<std::string> seen;
  for (const std::string& log : all.logs()) {
    if (!seen.insert(log).second) continue;
    if (IsPlainText(log)) {
      found.logs.push_back(log);
    } else {
      found.left_out.push_back(Printable(log));
    }
  }
  if (found.logs.empty() && !found.left_out.empty()) {
    throw ConfigError(found.left_out.front() + kBadName);
  }
  return found;
}

}  // namespace sprout::batch
