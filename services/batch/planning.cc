#include "services/batch/planning.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <atomic>
#include <fstream>
#include <iostream>
#include <mutex>
#include <set>
#include <thread>

#include "common/app/progress.h"
#include "common/bus/channels.h"
#include "common/core/digest.h"
#include "common/core/input_files.h"
#include "common/core/interrupt.h"
#include "common/core/printable.h"
#include "common/logfile/log_error.h"
#include "services/batch/logs_below.h"
#include "services/batch/names.h"
#include "services/batch/result_folder.h"
#include "services/batch/shard_run.h"
#include "services/batch/text_file.h"

namespace sprout::batch {
namespace {

namespace fs = std::filesystem;

constexpr char kBadName[] =
    ": is not allowed in the manifest; allowed are names in UTF-8 without control characters";

std::string Absolute(const fs::path& path) { return fs::absolute(path).lexically_normal(); }

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
      logs_.push_back(Absolute(input));
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
    if (std::find(open_.begin(), open_.end(), canonical) != open_.end()) {
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

Variant MakeVariant(const std::string& name, const StageNames& stages, const SproutConfig& config,
                    const std::string& programs) {
  Variant variant{.name = name, .config_digest = Digest(ConfigText(config)), .programs = {}};
  for (const std::string& stage : stages) {
    variant.programs[stage] = DescribeProgram(Absolute(fs::path(programs) / ("sprout-" + stage)));
  }
  return variant;
}

struct Wanted {
  BatchHead head;
  std::vector<SproutConfig> configs;
};

StageNames KeepOf(const BatchRequest& request, const StageNames& stages) {
  if (request.keep.empty()) return {stages.back()};
  for (const std::string& stage : request.keep) {
    if (std::find(stages.begin(), stages.end(), stage) == stages.end()) {
      throw ConfigError("--keep " + stage + ": allowed are stages of --stages");
    }
  }
  StageNames keep;
  for (const std::string& stage : stages) {
    const bool named =
        std::find(request.keep.begin(), request.keep.end(), stage) != request.keep.end();
    if (named || stage == stages.back()) keep.push_back(stage);
  }
  return keep;
}

Wanted Understand(const BatchRequest& request, const std::string& program) {
  Wanted wanted;
  BatchHead& head = wanted.head;
  head.stages = ParseStages("--stages", request.stages);
  head.keep = KeepOf(request, head.stages);
  if (!IsChannelPrefix(request.prefix)) {
    throw ConfigError(fmt::format("--channel-prefix '{}': allowed are {}",
                                  Printable(request.prefix), AllowedChannelPrefix()));
  }
  head.prefix = request.prefix;
  head.shard_bytes = request.shard_megabytes * 1'000'000;
  head.measured = request.measured;
  head.tables = FileDigest(program);
  if (!request.truth.empty()) {
    if (!fs::is_directory(request.truth)) {
      throw ConfigError(fmt::format("--truth {}: no such folder", request.truth));
    }
    head.truth = Absolute(request.truth);
  }
  wanted.configs.push_back(LoadConfig(request.config_a));
  head.variants.push_back(MakeVariant("a", head.stages, wanted.configs[0], request.programs_a));
  if (request.config_b.empty() && request.programs_b.empty()) return wanted;
  wanted.configs.push_back(request.config_b.empty() ? wanted.configs[0]
                                                    : LoadConfig(request.config_b));
  head.variants.push_back(
      MakeVariant("b", head.stages, wanted.configs[1],
                  request.programs_b.empty() ? request.programs_a : request.programs_b));
  Variant as_a = head.variants[1];
  as_a.name = head.variants[0].name;
  for (auto& [stage, b] : as_a.programs) b.path = head.variants[0].programs[stage].path;
  if (as_a == head.variants[0]) {
    throw ConfigError("--config-b, --programs-b: B is the same as A, there is nothing to compare");
  }
  if (!(InputsOf(head.stages, wanted.configs[0]) == InputsOf(head.stages, wanted.configs[1]))) {
    throw ConfigError(
        "--config-b: A and B take other channels from the logs; allowed are other stages: with "
        "refine as the first they take the same");
  }
  return wanted;
}

// What goes into the manifest.
void RequirePlainTexts(const BatchRequest& request) {
  RequirePlainText("--out", request.out);
  RequirePlainText("--programs-a", request.programs_a);
  RequirePlainText("--programs-b", request.programs_b);
  RequirePlainText("--truth", request.truth);
}

bool IsSame(const Manifest& manifest, const BatchHead& head, const std::vector<std::string>& logs) {
  if (!(manifest.head == head) || manifest.logs.size() != logs.size()) return false;
  for (size_t i = 0; i < logs.size(); ++i) {
    if (manifest.logs[i].path != logs[i]) return false;
    const FileStamp& stamp = manifest.logs[i].summary.stamp;
    if (!(stamp == StampOf(logs[i])) || !LogIndex::IsOf(manifest.logs[i].index, stamp)) {
      return false;
    }
  }
  return true;
}

}  // namespace

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

void SayLeftOut(const std::vector<std::string>& left_out) {
  for (const std::string& log : left_out) {
    std::cerr << "sprout-batch: left out: " << log << kBadName << "\n";
  }
}

int64_t IndexLogs(const std::vector<std::string>& logs, const fs::path& fallback) {
  Progress progress(/*quiet=*/false);
  std::atomic<size_t> next = 0;
  std::atomic<int64_t> elsewhere = 0;
  std::mutex mutex;
  std::vector<std::string> failures;
  std::vector<std::string> replaced;
  const auto work = [&] {
    for (size_t i = next++; i < logs.size() && !Interrupt::requested(); i = next++) {
      try {
        const LogIndex index = LogIndex::Ensure(logs[i], fallback);
        if (index.path().parent_path() == fallback) ++elsewhere;
        const std::lock_guard lock(mutex);
        if (!index.replaced().empty()) replaced.push_back(index.replaced());
        progress.Show(fmt::format("indexed {} of {} logs", i + 1, logs.size()));
      } catch (const std::exception& e) {
        const std::lock_guard lock(mutex);
        failures.emplace_back(e.what());
      }
    }
  };
  {
    std::vector<std::jthread> workers;
    for (unsigned i = 0; i < std::max(1U, std::thread::hardware_concurrency()); ++i) {
      workers.emplace_back(work);
    }
  }
  progress.Clear();
  std::sort(replaced.begin(), replaced.end());
  for (const std::string& why : replaced) {
    std::cerr << "sprout-batch: " << why << "; the log was indexed again\n";
  }
  Interrupt::Check();
  if (failures.empty()) return elsewhere;
  throw ConfigError(failures.size() == 1 ? failures[0]
                                         : fmt::format("{} logs cannot be used:\n{}",
                                                       failures.size(), fmt::join(failures, "\n")));
}

Manifest Plan(const BatchRequest& request, const std::string& program) {
  const BatchFolder folder(Absolute(request.out));
  RequirePlainTexts(request);
  const FoundLogs found = FindLogs(request.inputs);
  const std::vector<std::string>& logs = found.logs;
  SayLeftOut(found.left_out);
  Wanted wanted = Understand(request, program);
  wanted.head.left_out = found.left_out;
  if (fs::exists(folder.manifest())) {
    Manifest manifest = ReadManifest(folder.manifest());
    if (IsSame(manifest, wanted.head, logs)) return manifest;
  }
  if (const int64_t elsewhere = IndexLogs(logs, folder.indexes()); elsewhere > 0) {
    std::cout << fmt::format(
        "the indexes of {} logs are kept in {}: they cannot be written beside the logs\n",
        elsewhere, folder.indexes().string());
  }
  Manifest manifest{.head = wanted.head, .logs = {}, .shards = {}};
  const PlanOptions options{.inputs = InputsOf(wanted.head.stages, wanted.configs[0]),
                            .prefix = wanted.head.prefix,
                            .shard_bytes = wanted.head.shard_bytes};
  std::set<std::string> names;
  for (const std::string& log : logs) {
    const LogIndex index = LogIndex::Ensure(log, folder.indexes());
    LogPlan plan = PlanShards(index, options);
    for (Shard& shard : plan.shards) {
      shard.log = std::ssize(manifest.logs);
      manifest.shards.push_back(std::move(shard));
    }
    manifest.logs.push_back({.path = log,
                             .name = ResultNameOf(log, names),
                             .index = Absolute(index.path()),
                             .summary = index.summary(),
                             .incomplete = plan.incomplete,
                             .left_out = plan.left_out});
  }
  if (manifest.shards.empty()) {
    throw ConfigError(fmt::format(
        "no frame is complete in these logs; {} needs {}; see sprout-log info, "
        "--channel-prefix and --stages",
        wanted.head.stages.front(), fmt::join(ChannelsOf(options.inputs, options.prefix), ", ")));
  }
  for (size_t i = 0; i < wanted.configs.size(); ++i) {
    WriteText(folder.config(wanted.head.variants[i].name), ConfigText(wanted.configs[i]));
  }
  fs::remove_all(folder.failures());  // its shards had other numbers
  WriteManifest(folder.manifest(), manifest);
  return manifest;
}

}  // namespace sprout::batch
