#include "services/tools/batch/planning.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <map>
#include <utility>

#include "common/app/process.h"
#include "common/app/program.h"
#include "common/app/progress.h"
#include "common/config/config_error.h"
#include "common/core/digest.h"
#include "common/core/input_files.h"
#include "common/core/number_text.h"
#include "common/core/printable.h"
#include "common/core/read_text.h"
#include "common/core/signal_watcher.h"
#include "common/logfile/log_error.h"
#include "common/logfile/log_reader.h"
#include "services/tools/batch/log_task.h"
#include "services/tools/batch/result_folder.h"

namespace sprout::batch {
namespace {

namespace fs = std::filesystem;

std::string Absolute(const fs::path& path) { return fs::absolute(path).lexically_normal(); }

// Program and what --version says. @throws ConfigError when it cannot be started.
StageProgram DescribeProgram(const std::string& path) {
  Process process({path, "--version"});
  if (process.Wait() != 0) throw ConfigError(path + ": cannot be run");
  StageProgram program;
  program.set_path(path);
  program.set_digest(FileDigest(path));
  program.set_version(Printable(Trimmed(process.Output())));
  return program;
}

Variant MakeVariant(const Manifest& manifest, const SproutConfig& config,
                    const std::string& programs) {
  Variant variant;
  variant.set_config_digest(Digest(ConfigText(config)));
  for (const std::string& stage : manifest.stage()) {
    *variant.add_program() = DescribeProgram(Absolute(fs::path(programs) / ("sprout-" + stage)));
  }
  return variant;
}

// Whether two variants give the same results: paths of equal programs may differ.
bool AreAlike(const Variant& a, const Variant& b) {
  const auto digest = [](const StageProgram& program) { return program.digest(); };
  return a.config_digest() == b.config_digest() &&
         std::ranges::equal(a.program(), b.program(), {}, digest, digest);
}

// The settings that have nothing to do with logs and variants.
Manifest SettingsOf(const BatchRequest& request, const std::string& program) {
  Manifest manifest;
  manifest.set_format(kManifestFormat);
  RequireStages("--stages", request.stages);
  for (const std::string& stage : request.stages) manifest.add_stage(stage);
  RequireChannelPrefix(request.prefix);
  manifest.set_channel_prefix(request.prefix);
  manifest.set_tables(FileDigest(program));
  return manifest;
}

// @param programs  folder of A's.
// @returns the effective configuration of each.
std::vector<SproutConfig> AddVariants(const BatchRequest& request, const std::string& programs,
                                      Manifest& manifest) {
  std::vector<SproutConfig> configs = {LoadConfig(request.config_a)};
  *manifest.add_variant() = MakeVariant(manifest, configs[0], programs);
  if (request.config_b.empty() && request.programs_b.empty()) return configs;
  configs.push_back(request.config_b.empty() ? configs[0] : LoadConfig(request.config_b));
  *manifest.add_variant() =
      MakeVariant(manifest, configs[1], request.programs_b.empty() ? programs : request.programs_b);
  if (AreAlike(manifest.variant(0), manifest.variant(1))) {
    throw ConfigError("--config-b, --programs-b: B is the same as A, there is nothing to compare");
  }
  return configs;
}

// @param known  logs of an earlier manifest, by path, whose digests hold unless the file changed.
void AddLogs(const std::vector<std::string>& paths, const std::map<std::string, BatchLog>& known,
             Manifest& manifest) {
  Progress progress(/*quiet=*/false);
  std::set<std::string> names;
  std::vector<std::string> failures;
  for (const std::string& path : paths) {
    Interrupt::Check();
    progress.Show(fmt::format("reading log {} of {}", manifest.log_size() + 1, paths.size()));
    BatchLog& log = *manifest.add_log();
    log.set_path(path);
    log.set_name(ResultNameOf(path, names));
    try {
      const FileStamp stamp = StampOf(path);
      log.set_bytes(stamp.bytes);
      log.set_mtime_ns(stamp.mtime_ns);
      const auto old = known.find(path);
      if (old != known.end() && stamp == FileStamp{old->second.bytes(), old->second.mtime_ns()}) {
        log.set_digest(old->second.digest());
        continue;
      }
      (void)LogReader(path);  // throws if it is no log
      log.set_digest(FileDigest(path));
    } catch (const LogError& e) {
      failures.emplace_back(e.what());
    }
  }
  progress.Clear();
  if (failures.empty()) return;
  throw ConfigError(failures.size() == 1 ? failures[0]
                                         : fmt::format("{} logs cannot be used:\n{}",
                                                       failures.size(), fmt::join(failures, "\n")));
}

// Collects the logs of the inputs, also of lists in lists.
class Inputs {
 public:
  void Add(const std::string& input) {
    std::error_code ignored;
    if (input.starts_with('@')) {
      AddList(input.substr(1));
    } else if (fs::is_directory(input, ignored)) {
      const std::vector<std::string> found = LogsBelow(input);
      logs_.insert(logs_.end(), found.begin(), found.end());
    } else if (fs::is_regular_file(input, ignored)) {
      logs_.push_back(fs::absolute(input).lexically_normal());
    } else {
      throw ConfigError(Printable(input) + ": no such log or folder" + WhyClosed(input));
    }
  }

  const std::vector<std::string>& logs() const { return logs_; }

 private:
  void AddList(const std::string& path) {
    NoteInputFile(path);
    std::ifstream list(path);
    // A pipe is as good as a file; others, such as /dev/zero, may never end.
    if (!list || !(fs::is_regular_file(path) || fs::is_fifo(path))) {
      throw ConfigError("@" + Printable(path) + ": no such list" + WhyClosed(path) +
                        "; allowed: a text file, a log a line");
    }
    const fs::path canonical = fs::canonical(path);
    if (std::ranges::count(open_, canonical) > 0) {
      throw ConfigError("@" + Printable(path) + ": the list contains itself");
    }
    open_.push_back(canonical);
    constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";
    for (std::string line; std::getline(list, line);) {  // Windows' editors write these two
      if (line.starts_with(kByteOrderMark)) line.erase(0, kByteOrderMark.size());
      if (line.ends_with('\r')) line.pop_back();
      if (!line.empty()) Add(line);
    }
    open_.pop_back();
  }

  std::vector<std::string> logs_;
  std::vector<fs::path> open_;  // lists being read, each inside the one before
};

void RequireReadable(const fs::path& folder) {
  if (eaccess(folder.c_str(), R_OK | X_OK) == 0) return;
  throw ConfigError(Printable(folder.string()) + ": cannot be read (" +
                    std::generic_category().message(errno) + ")");
}

// Whether it is an answer in a batch's folder OUT, results/GROUP/KEY/answers.lcm, or a link to one.
bool IsOfABatch(const fs::path& log) {
  std::error_code gone;
  const fs::path results = fs::canonical(log, gone).parent_path().parent_path().parent_path();
  return results.filename() == "results" &&
         fs::exists(BatchFolder(results.parent_path()).manifest(), gone);
}

constexpr size_t kLongestName = 200;  // a file name has 255 bytes, and endings come behind it
constexpr std::string_view kNotInNames = "/,\"";

}  // namespace

Manifest Plan(const BatchRequest& request, const std::string& program) {
  const BatchFolder folder(Absolute(request.out));
  RequirePlainText("--out", request.out);  // these go into the manifest
  RequirePlainText("--programs-b", request.programs_b);
  const std::vector<std::string> logs = FindLogs(request.inputs);
  Manifest manifest = SettingsOf(request, program);
  const std::vector<SproutConfig> configs =
      AddVariants(request, fs::path(program).parent_path(), manifest);
  std::string before;
  std::map<std::string, BatchLog> known;
  if (fs::exists(folder.manifest())) {
    const Manifest old = ReadManifest(folder.manifest());
    before = ConfigText(old);
    for (const BatchLog& log : old.log()) known[log.path()] = log;
  }
  AddLogs(logs, known, manifest);
  for (size_t i = 0; i < configs.size(); ++i) {
    WriteText(folder.config(static_cast<int>(i)), ConfigText(configs[i]));
  }
  if (ConfigText(manifest) == before) return manifest;
  ForgetTries(folder);  // its logs had other numbers
  WriteText(folder.manifest(), ConfigText(manifest));
  return manifest;
}

std::vector<std::string> LogsBelow(const fs::path& folder) {
  std::vector<std::pair<bool, std::string>> names;  // links last
  RequireReadable(folder);
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_directory() && !entry.is_symlink()) RequireReadable(entry);
    if (entry.is_regular_file() && entry.path().extension() == ".lcm" && !IsOfABatch(entry)) {
      names.emplace_back(entry.is_symlink(), fs::absolute(entry.path()).lexically_normal());
    }
  }
  std::sort(names.begin(), names.end());
  std::vector<std::string> logs;
  std::set<std::pair<dev_t, ino_t>> files;
  for (const auto& [is_link, name] : names) {
    struct stat status {};
    if (stat(name.c_str(), &status) != 0) continue;  // removed meanwhile
    if (files.emplace(status.st_dev, status.st_ino).second) logs.push_back(name);
  }
  if (logs.empty()) throw ConfigError(folder.string() + ": no log (*.lcm) in this folder");
  std::sort(logs.begin(), logs.end());
  return logs;
}

std::vector<std::string> FindLogs(const std::vector<std::string>& inputs) {
  Inputs all;
  for (const std::string& input : inputs) all.Add(input);
  std::vector<std::string> logs;
  std::set<std::string> seen;
  for (const std::string& log : all.logs()) {
    RequirePlainText("log", log);  // it goes into the manifest
    std::error_code gone;
    const fs::path file = fs::canonical(log, gone);  // also of a link to it
    if (seen.insert(gone ? log : file.string()).second) logs.push_back(log);
  }
  return logs;
}

bool IsPlainText(std::string_view text) { return Printable(text) == text; }

void RequirePlainText(const std::string& flag, const std::string& text) {
  if (IsPlainText(text)) return;
  throw ConfigError(
      fmt::format("{} '{}': allowed is UTF-8 without control characters", flag, Printable(text)));
}

bool IsResultName(std::string_view name) {
  return !name.empty() && name.size() <= kLongestName && name != "." && name != ".." &&
         name.find_first_of(kNotInNames) == std::string_view::npos && IsPlainText(name);
}

std::string ResultNameOf(const std::filesystem::path& log, std::set<std::string>& taken) {
  constexpr size_t kRoomForNumber = 20;
  std::string stem = Shortened(log.stem().string(), kLongestName - kRoomForNumber);
  for (char& letter : stem) {
    if (kNotInNames.find(letter) != std::string_view::npos) letter = '_';
  }
  if (!IsResultName(stem)) stem = "log";
  std::string name = stem;
  for (int i = 2; !taken.insert(name).second; ++i) name = fmt::format("{}-{}", stem, i);
  return name;
}

}  // namespace sprout::batch
