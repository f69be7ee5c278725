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
#include "common/core/digest.h"
#include "common/logfile/log_error.h"
#include "services/batch/interrupt.h"
#include "services/batch/shard_run.h"
#include "services/batch/text_file.h"

namespace sprout::batch {
namespace {

namespace fs = std::filesystem;

std::string Absolute(const fs::path& path) { return fs::absolute(path).lexically_normal(); }

void AddInput(const std::string& input, std::vector<std::string>& logs) {
  if (input.starts_with('@')) {
    std::ifstream list(input.substr(1));
    if (!list) throw ConfigError(input + ": no such list; allowed: a text file, a log a line");
    for (std::string line; std::getline(list, line);) {
      if (!line.empty()) AddInput(line, logs);
    }
  } else if (fs::is_directory(input)) {
    std::vector<std::string> found;
    for (const auto& entry : fs::recursive_directory_iterator(input)) {
      if (entry.is_regular_file() && entry.path().extension() == ".lcm") {
        found.push_back(Absolute(entry.path()));
      }
    }
    if (found.empty()) throw ConfigError(input + ": no log (*.lcm) in this folder");
    std::sort(found.begin(), found.end());
    logs.insert(logs.end(), found.begin(), found.end());
  } else if (fs::is_regular_file(input)) {
    logs.push_back(Absolute(input));
  } else {
    throw ConfigError(input + ": no such log or folder");
  }
}

// The file's name, and a number behind it when another log has it already.
std::string NameOf(const std::string& log, std::set<std::string>& taken) {
  const std::string stem = fs::path(log).stem();
  std::string name = stem;
  for (int i = 2; !taken.insert(name).second; ++i) name = fmt::format("{}-{}", stem, i);
  std::replace(name.begin(), name.end(), ',', '_');  // it stands in a table
  return name;
}

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
  head.prefix = request.prefix;
  head.shard_bytes = request.shard_megabytes * 1'000'000;
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

bool IsSame(const Manifest& manifest, const BatchHead& head, const std::vector<std::string>& logs) {
  if (!(manifest.head == head) || manifest.logs.size() != logs.size()) return false;
  for (size_t i = 0; i < logs.size(); ++i) {
    if (manifest.logs[i].path != logs[i]) return false;
    if (!(manifest.logs[i].summary.stamp == StampOf(logs[i]))) return false;
    if (!fs::exists(manifest.logs[i].index)) return false;
  }
  return true;
}

}  // namespace

std::vector<std::string> FindLogs(const std::vector<std::string>& inputs) {
  std::vector<std::string> found;
  for (const std::string& input : inputs) AddInput(input, found);
  std::vector<std::string> logs;
  std::set<std::string> seen;
  for (std::string& log : found) {
    if (seen.insert(log).second) logs.push_back(std::move(log));
  }
  return logs;
}

int64_t IndexLogs(const std::vector<std::string>& logs, const fs::path& fallback) {
  Progress progress(/*quiet=*/false);
  std::atomic<size_t> next = 0;
  std::atomic<int64_t> elsewhere = 0;
  std::mutex mutex;
  std::vector<std::string> failures;
  const auto work = [&] {
    for (size_t i = next++; i < logs.size() && !Interrupt::requested(); i = next++) {
      try {
        const LogIndex index = LogIndex::Ensure(logs[i], fallback);
        if (index.path().parent_path() == fallback) ++elsewhere;
        const std::lock_guard lock(mutex);
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
  Interrupt::Check();
  if (failures.empty()) return elsewhere;
  throw ConfigError(failures.size() == 1 ? failures[0]
                                         : fmt::format("{} logs cannot be used:\n{}",
                                                       failures.size(), fmt::join(failures, "\n")));
}

Manifest Plan(const BatchRequest& request, const std::string& program) {
  const BatchFolder folder(Absolute(request.out));
  const std::vector<std::string> logs = FindLogs(request.inputs);
  const Wanted wanted = Understand(request, program);
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
                             .name = NameOf(log, names),
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
