#include "services/tools/batch/planning.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <iostream>
#include <map>
#include <set>

#include "common/app/process.h"
#include "common/app/progress.h"
#include "common/bus/channels.h"
#include "common/core/digest.h"
#include "common/core/interrupt.h"
#include "common/core/printable.h"
#include "common/logfile/log_error.h"
#include "common/logfile/log_reader.h"
#include "services/tools/batch/log_list.h"
#include "services/tools/batch/log_task.h"
#include "services/tools/batch/names.h"
#include "services/tools/batch/result_folder.h"

namespace sprout::batch {
namespace {

namespace fs = std::filesystem;

std::string Absolute(const fs::path& path) { return fs::absolute(path).lexically_normal(); }

// Program and what --version says. @throws ConfigError when it cannot be started.
StageProgram DescribeProgram(const std::string& path) {
  Process process({path, "--version"});
  if (process.Wait() != 0) throw ConfigError(path + ": cannot be run");
  std::string version = process.Output();
  while (!version.empty() && std::isspace(static_cast<unsigned char>(version.back())) != 0) {
    version.pop_back();
  }
  StageProgram program;
  program.set_path(path);
  program.set_digest(FileDigest(path));
  program.set_version(Printable(version));
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

// Whether they give the same, wherever their programs lie.
bool AreAlike(const Variant& a, const Variant& b) {
  const auto digest = [](const StageProgram& program) { return program.digest(); };
  return a.config_digest() == b.config_digest() &&
         std::ranges::equal(a.program(), b.program(), {}, digest, digest);
}

void AddKeep(const BatchRequest& request, Manifest& manifest) {
  for (const std::string& stage : request.keep) {
    if (std::ranges::count(manifest.stage(), stage) == 0) {
      throw ConfigError("--keep " + Printable(stage) + ": allowed are stages of --stages");
    }
  }
  for (const std::string& stage : manifest.stage()) {
    const bool is_last = stage == *manifest.stage().rbegin();
    if (is_last || std::ranges::count(request.keep, stage) > 0) manifest.add_keep(stage);
  }
}

// The settings that have nothing to do with logs and variants.
Manifest SettingsOf(const BatchRequest& request, const std::string& program) {
  Manifest manifest;
  manifest.set_format(kManifestFormat);
  RequireStages("--stages", request.stages);
  for (const std::string& stage : request.stages) manifest.add_stage(stage);
  AddKeep(request, manifest);
  if (!IsChannelPrefix(request.prefix)) {
    throw ConfigError(fmt::format("--channel-prefix '{}': allowed are {}",
                                  Printable(request.prefix), AllowedChannelPrefix()));
  }
  manifest.set_channel_prefix(request.prefix);
  manifest.set_measured(!request.no_measures);
  manifest.set_tables(FileDigest(program));
  if (request.truth.empty()) return manifest;
  if (!fs::is_directory(request.truth)) {
    throw ConfigError(fmt::format("--truth {}: no such folder", request.truth));
  }
  manifest.set_truth(Absolute(request.truth));
  return manifest;
}

// @returns the effective configuration of each.
std::vector<SproutConfig> AddVariants(const BatchRequest& request, Manifest& manifest) {
  std::vector<SproutConfig> configs = {LoadConfig(request.config_a)};
  *manifest.add_variant() = MakeVariant(manifest, configs[0], request.programs_a);
  if (request.config_b.empty() && request.programs_b.empty()) return configs;
  configs.push_back(request.config_b.empty() ? configs[0] : LoadConfig(request.config_b));
  *manifest.add_variant() = MakeVariant(
      manifest, configs[1], request.programs_b.empty() ? request.programs_a : request.programs_b);
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
      (void)LogReader(path);  // is it a log?
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

}  // namespace

void SayLeftOut(const Manifest& manifest) {
  for (const std::string& log : manifest.left_out()) {
    std::cerr << "sprout-batch: left out: " << log << kBadName << "\n";
  }
}

Manifest Plan(const BatchRequest& request, const std::string& program) {
  const BatchFolder folder(Absolute(request.out));
  RequirePlainText("--out", request.out);  // these go into the manifest
  RequirePlainText("--programs-a", request.programs_a);
  RequirePlainText("--programs-b", request.programs_b);
  RequirePlainText("--truth", request.truth);
  const FoundLogs found = FindLogs(request.inputs);
  Manifest manifest = SettingsOf(request, program);
  manifest.mutable_left_out()->Assign(found.left_out.begin(), found.left_out.end());
  SayLeftOut(manifest);
  const std::vector<SproutConfig> configs = AddVariants(request, manifest);
  std::string before;
  std::map<std::string, BatchLog> known;
  if (fs::exists(folder.manifest())) {
    const Manifest old = ReadManifest(folder.manifest());
    before = ConfigText(old);
    for (const BatchLog& log : old.log()) known[log.path()] = log;
  }
  AddLogs(found.logs, known, manifest);
  for (size_t i = 0; i < configs.size(); ++i) {
    WriteText(folder.config(static_cast<int>(i)), ConfigText(configs[i]));
  }
  if (ConfigText(manifest) == before) return manifest;
  fs::remove_all(folder.failures());  // its logs had other numbers
  WriteText(folder.manifest(), ConfigText(manifest));
  return manifest;
}

}  // namespace sprout::batch
