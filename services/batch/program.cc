#include "services/batch/program.h"

#include <fcntl.h>
#include <fmt/core.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <iostream>

#include "common/app/program.h"
#include "common/app/version.h"
#include "common/core/digest.h"
#include "common/core/interrupt.h"
#include "common/core/shell_word.h"
#include "common/logfile/log_error.h"
#include "services/batch/engines.h"
#include "services/batch/planning.h"
#include "services/batch/report.h"
#include "services/batch/shard_run.h"
#include "services/batch/shard_try.h"
#include "services/batch/text_file.h"

namespace sprout::batch {
namespace {

namespace fs = std::filesystem;

constexpr char kDescription[] =
    "Replays stages on many logs, on all cores or with Slurm, compares two configurations or "
    "two\n"
    "builds frame by frame, and writes a table and a report.";

constexpr char kFooter[] = R"(
Examples
  sprout-batch run logs/ --out out/fast --config fast           one configuration
  sprout-batch run logs/ --out out/ab --config default --config-b default --config-b try.textproto
  sprout-batch run logs/ --out out/new --programs-b ../new/build/release/bin     two builds
  sprout-batch run @list.txt --out /shared/ab --engine slurm --partition short   on a cluster
  sprout-batch status /shared/ab

Repeating a command computes only what is missing. `sprout-batch COMMAND --help` explains
a command. Exit codes: 0; 1 something is missing; 2 a flag or log that cannot be used; 130 Ctrl-C.
)";

struct Options {
  BatchRequest request;
  bool no_measures = false;
  std::string engine = "local";
  LocalOptions local;
  SlurmOptions slurm;
  std::string out;
  std::vector<size_t> shards;
  std::vector<std::string> logs;
  int round = 0;
};

std::string OwnPath() { return fs::read_symlink("/proc/self/exe"); }

// Two runs at once on one folder would only take work from each other.
class FolderLock {
 public:
  explicit FolderLock(const BatchFolder& folder) {
    std::error_code error;
    fs::create_directories(folder.root(), error);
    const fs::path path = folder.root() / "lock";
    descriptor_ = open(path.c_str(), O_CREAT | O_RDWR | O_CLOEXEC, 0666);
    if (descriptor_ < 0)
      throw ConfigError("--out " + folder.root().string() + ": cannot be written");
    if (flock(descriptor_, LOCK_EX | LOCK_NB) == 0) return;
    close(descriptor_);
    throw ConfigError("--out " + folder.root().string() +
                      ": another sprout-batch is running there");
  }
  ~FolderLock() { close(descriptor_); }
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  int descriptor_;
};

// Of all that the report is made from.
std::string ReportSource(const BatchFolder& folder, const BatchState& state) {
  std::string text = FileDigest(folder.manifest());
  for (const bool done : state.done) text += done ? '1' : '0';
  return Digest(text);
}

void Report(const BatchFolder& folder, const Manifest& manifest, const BatchState& state) {
  WriteFrameTable(folder, manifest, state);
  WriteReport(folder, manifest, state, OwnPath());
  const std::string source = ReportSource(folder, state);
  MarkMadeFrom(folder.table(), source);
  MarkMadeFrom(folder.report(), source);
  std::cout << fmt::format("table  {}\nreport {}\n", folder.table().string(),
                           folder.report().string());
}

// What of the logs no shard has, in one line; nothing when that is nothing.
std::string InputLosses(const Manifest& manifest) {
  const std::vector<size_t> shards_of_log = [&] {
    std::vector<size_t> count(manifest.logs.size(), 0);
    for (const Shard& shard : manifest.shards) ++count[static_cast<size_t>(shard.log)];
    return count;
  }();
  int64_t incomplete = 0;
  int64_t left_out = 0;
  int64_t unreadable = 0;
  int64_t damaged = 0;
  for (const BatchLog& log : manifest.logs) {
    incomplete += log.incomplete;
    left_out += log.left_out;
    unreadable += log.summary.undecodable;
    damaged += log.summary.damaged_bytes;
  }
  const auto without = std::count(shards_of_log.begin(), shards_of_log.end(), 0U);
  if (without + incomplete + left_out + unreadable + damaged == 0) return "";
  return fmt::format(
      "in the logs: {} incomplete frames, {} frame numbers missing, {} unreadable messages, {} "
      "damaged bytes; {} logs without a complete frame\n",
      incomplete, left_out, unreadable, damaged, without);
}

// Merges, and reports when there is something new.
int Finish(const BatchFolder& folder, const Manifest& manifest, const BatchState& state) {
  MergeLogs(folder, manifest, state);
  const std::string source = ReportSource(folder, state);
  if (IsMadeFrom(folder.table(), source) && IsMadeFrom(folder.report(), source)) {
    std::cout << fmt::format("all {} shards were done already; report {}\n",
                             manifest.shards.size() - static_cast<size_t>(state.missing),
                             folder.report().string());
  } else {
    Report(folder, manifest, state);
  }
  if (state.missing > 0) {
    std::cerr << fmt::format("sprout-batch: {} of {} shards are missing; why: {}\n", state.missing,
                             manifest.shards.size(), folder.failures().string());
  }
  return state.missing == 0 && manifest.head.left_out.empty() ? 0 : 1;
}

int RunRun(Options& options) {
  options.request.measured = !options.no_measures;
  options.slurm.retries = options.local.retries;
  options.request.out = fs::absolute(options.request.out).lexically_normal();
  if (options.request.programs_a.empty()) {
    options.request.programs_a = fs::path(OwnPath()).parent_path();
  }
  const BatchFolder folder(options.request.out);
  const FolderLock lock(folder);
  const Interrupt interrupt;
  if (const std::string jobs = ActiveJobs(folder); !jobs.empty()) {
    throw ConfigError(
        fmt::format("--out {}: Slurm's jobs {} are running there; wait, or scancel {}",
                    folder.root().string(), jobs, jobs));
  }
  RemoveParts(folder);
  const Manifest manifest = Plan(options.request, OwnPath());
  const BatchState state = CheckedStateOf(folder, manifest);
  int64_t frames = 0;
  for (const Shard& shard : manifest.shards) frames += shard.frames;
  std::cout << fmt::format("{} logs, {} frames, {} shards, {} of them to do\n",
                           manifest.logs.size(), frames, manifest.shards.size(), state.missing)
            << InputLosses(manifest);
  if (state.missing == 0) return Finish(folder, manifest, state);
  if (options.engine == "slurm") {
    std::cout << SubmitSlurm(OwnPath(), folder, state, options.slurm, 0) << "\n"
              << "sprout-batch status " << ShellWord(folder.root().string())
              << " shows the progress\n";
    return 0;
  }
  RunLocal(OwnPath(), folder, manifest, state, options.local);
  return Finish(folder, manifest, StateOf(folder, manifest));
}

int RunMergeJob(const Options& options) {
  const BatchFolder folder(options.out);
  const Manifest manifest = ReadManifest(folder.manifest());
  const BatchState state = CheckedStateOf(folder, manifest);
  if (state.missing > 0 && options.round < options.slurm.retries) {
    std::cout << SubmitSlurm(OwnPath(), folder, state, options.slurm, options.round + 1) << "\n";
  }
  MergeLogs(folder, manifest, state);
  return state.missing == 0 ? 0 : 1;
}

int RunShards(const Options& options) {
  const BatchFolder folder(options.out);
  int exit_code = 0;
  for (const size_t shard : options.shards) {
    try {
      RunShard(folder, shard);
    } catch (const ConfigError&) {
      throw;
    } catch (const std::runtime_error& e) {  // the others are still worth doing
      std::cerr << "sprout-batch: " << e.what() << "\n";
      exit_code = 1;
    }
  }
  return exit_code;
}

int RunStatus(const Options& options) {
  const BatchFolder folder(fs::absolute(options.out).lexically_normal());
  const Manifest manifest = ReadManifest(folder.manifest());
  const BatchState state = StateOf(folder, manifest);
  std::cout << fmt::format("{} of {} shards are done\n",
                           manifest.shards.size() - static_cast<size_t>(state.missing),
                           manifest.shards.size());
  for (const auto& [shard, tries] : FailedTries(folder)) {
    if (shard >= state.done.size()) continue;
    std::cout << fmt::format("shard {} {}: {}\n", shard,
                             state.done[shard] ? "is done after a failure" : "failed or is running",
                             TryPath(folder, shard, tries).string());
  }
  SayLeftOut(manifest.head.left_out);
  const std::string jobs = ActiveJobs(folder);
  if (!jobs.empty()) std::cout << "Slurm's jobs " << jobs << " are running\n";
  return state.missing == 0 && manifest.head.left_out.empty() ? 0 : 1;
}

int RunReport(const Options& options) {
  const BatchFolder folder(fs::absolute(options.out).lexically_normal());
  const Manifest manifest = ReadManifest(folder.manifest());
  return Finish(folder, manifest, CheckedStateOf(folder, manifest));
}

int RunIndex(const Options& options) {
  const Interrupt interrupt;
  const FoundLogs found = FindLogs(options.logs);
  SayLeftOut(found.left_out);
  IndexLogs(found.logs, /*fallback=*/"");
  std::cout << fmt::format("{} logs have an index\n", found.logs.size());
  return found.left_out.empty() ? 0 : 1;
}

Flag AddList(Flags& flags, const char* name, std::vector<std::string>& list, const char* text) {
  return flags.Add(name, list, text).Repeatable();
}

void AddSlurm(Flags& flags, SlurmOptions& slurm) {
  flags.Add("--partition", slurm.partition, "Slurm: partition (default: the cluster's)");
  flags.Add("--memory", slurm.memory, "Slurm: memory of a task").ShowDefault();
  flags.Add("--time", slurm.time, "Slurm: longest time of a task").ShowDefault();
  flags.Add("--array-size", slurm.array_size, "Slurm: most tasks of the job array")
      .WithinWhole(1, 4'000'000)
      .ShowDefault();
}

void AddRun(Flags& program, Options& options) {
  Flags& flags = program.AddCommand(
      "run", "Computes the missing results of a batch, or all of a new one, then table and report",
      [&options] { return RunRun(options); });
  BatchRequest& request = options.request;
  flags
      .Add("LOG", request.inputs,
           "Logs, folders of logs (*.lcm), or @LIST: a file with one of these a line")
      .Required();
  flags.Add("--out", request.out, "Folder of the batch; results are kept in it").Required();
  AddList(flags, "--stages", request.stages, "Stages to run, of refine,prior,grow,temporal")
      .SplitAtCommas()
      .ShowDefault();
  AddList(flags, "--keep", request.keep, "Stages whose answers are kept, beside the last one's")
      .SplitAtCommas();
  AddList(flags, "--config FILE|PRESET", request.config_a,
          "Configuration A, as for the services; several are merged");
  AddList(flags, "--config-b FILE|PRESET", request.config_b, "Configuration B, to compare with A");
  flags.Add("--programs-a", request.programs_a,
            "Folder of the stages' programs (default: that of sprout-batch)");
  flags.Add("--programs-b", request.programs_b, "Those of B, to compare with another build");
  flags.Add("--truth", request.truth,
            "Folder with LOGNAME/NNNNNN_disparity.pfm, true disparities of frames");
  flags.Add("--no-measures", options.no_measures,
            "Do not measure the frames: no score and no other figures of quality in the table");
  flags.Add("--channel-prefix", request.prefix, "Prefix of every channel of the logs");
  flags.Add("--shard-megabytes", request.shard_megabytes, "Approximate size of a shard")
      .WithinWhole(1, 1'000'000)
      .ShowDefault();
  flags.Add("--engine", options.engine, "Where to compute").OneOf({"local", "slurm"}).ShowDefault();
  flags.Add("--jobs", options.local.jobs, "local: shards at a time, 0 = one a core")
      .WithinWhole(0, 4096)
      .ShowDefault();
  flags.Add("--retries", options.local.retries, "How often a failed shard is tried again")
      .WithinWhole(0, 100)
      .ShowDefault();
  AddSlurm(flags, options.slurm);
}

void AddOthers(Flags& program, Options& options) {
  const auto add = [&](const char* name, const char* text, int (*run)(const Options&)) -> Flags& {
    Flags& flags = program.AddCommand(name, text, [&options, run] { return run(options); });
    flags.Add("OUT", options.out, "Folder of the batch").Required();
    return flags;
  };
  add("status", "Progress of a batch", RunStatus);
  add("report", "Writes merged logs, table and report of the finished shards", RunReport);
  add("run-shard", "Computes shards; called by both engines", RunShards)
      .Add("SHARD", options.shards, "Numbers of shards")
      .Required();
  Flags& merge = add("merge", "Merges logs; Slurm's merge job, which submits missing shards again",
                     RunMergeJob);
  merge.Add("--round", options.round, "Number of the submission").ShowDefault();
  merge.Add("--retries", options.slurm.retries, "Most rounds").ShowDefault();
  AddSlurm(merge, options.slurm);
  program
      .AddCommand("index", "Makes the indexes of logs, beside them",
                  [&options] { return RunIndex(options); })
      .Add("LOG", options.logs, "As for run")
      .Required();
}

}  // namespace

int BatchMain(int argc, const char* const* argv) {
  Flags program("sprout-batch", kDescription);
  program.SetFooter(kFooter);
  program.AddVersion(Version());
  program.RequireCommand();
  Options options;
  AddRun(program, options);
  AddOthers(program, options);
  return RunProgram(program, argc, argv, [&] {
    try {
      return program.RunCommand();
    } catch (const Interrupted& e) {
      std::cerr << "sprout-batch: " << e.what() << "; the same command continues from here\n";
      return 130;
    } catch (const LogError& e) {
      throw ConfigError(e.what());
    }
  });
}

}  // namespace sprout::batch
