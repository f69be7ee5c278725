#include <fcntl.h>
#include <fmt/core.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <filesystem>
#include <iostream>
#include <set>
#include <string>
#include <system_error>
#include <vector>

#include "common/app/compute.h"
#include "common/app/output_paths.h"
#include "common/app/program.h"
#include "common/core/printable.h"
#include "common/core/signal_watcher.h"
#include "services/tools/batch/engines.h"
#include "services/tools/batch/frame_table.h"
#include "services/tools/batch/log_task.h"
#include "services/tools/batch/planning.h"
#include "services/tools/batch/report.h"

namespace sprout::batch {
namespace {

// The flags of all commands.
struct Options {
  BatchRequest request;
  std::string engine = "local";
  LocalOptions local;
  SlurmOptions slurm;
  std::string out;
  std::vector<uint64_t> logs;  ///< numbers
  int threads = 1;
  int round = 0;
};

// The commands. Each returns the program's exit code.
// @throws ConfigError, LogError, Interrupted, std::runtime_error.

namespace fs = std::filesystem;

std::string OwnPath() { return fs::read_symlink("/proc/self/exe"); }

BatchFolder FolderOf(const std::string& out) {
  return BatchFolder(fs::absolute(out).lexically_normal());
}

// Lock of a batch's folder: two runs at once would compute the same logs.
class FolderLock {
 public:
  explicit FolderLock(const BatchFolder& folder) : folder_(folder) {
    std::error_code none;
    for (fs::path made = folder.root(); !made.empty() && !fs::exists(made, none);
         made = made.parent_path()) {
      made_.push_back(made);
    }
    RequireWritableFolder("--out", folder.root(), {});
    const fs::path path = folder.root() / "lock";
    descriptor_ = open(path.c_str(), O_CREAT | O_RDWR | O_CLOEXEC, 0666);
    if (descriptor_ < 0) {
      throw ConfigError("--out " + folder.root().string() + ": cannot be written (" +
                        std::generic_category().message(errno) + ")");
    }
    // Some network file systems have no locks.
    if (flock(descriptor_, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK) return;
    close(descriptor_);
    throw ConfigError("--out " + folder.root().string() +
                      ": another sprout-batch is running there");
  }
  ~FolderLock() {
    if (!made_.empty() && !fs::exists(folder_.manifest())) RemoveFolders();
    close(descriptor_);
  }
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  // Removes the folders that were made for a batch that was refused, if they are empty.
  void RemoveFolders() const {
    std::error_code ignored;
    fs::remove(folder_.root() / "lock", ignored);
    for (const fs::path& made : made_) fs::remove(made, ignored);
  }

  BatchFolder folder_;
  std::vector<fs::path> made_;  // the innermost first
  int descriptor_;
};

// Prints why Slurm's tasks ended, since logs may be missing of tasks that could not note a failure.
void PrintTaskOutput(const BatchFolder& folder, std::ostream& out) {
  const std::string said = TaskOutput(folder);
  if (!said.empty()) out << "Slurm's tasks ended with " << said << "\n";
}

// Warns that averages are over fewer logs than were given, which is no failure.
void WarnOfEmptyLogs(const Manifest& manifest, const BatchState& state, const FrameTable& frames) {
  std::set<int> with_frames;
  for (size_t row = 0; row < frames.size(); ++row) with_frames.insert(frames.LogOf(row));
  const auto empty = manifest.log_size() - state.missing - std::ssize(with_frames);
  if (empty == 0) return;
  std::cerr << fmt::format(
      "sprout-batch: {} of {} logs have no frame with an answer; the report "
      "names them\n",
      empty, manifest.log_size());
}

int Finish(const BatchFolder& folder, const Manifest& manifest, const BatchState& state) {
  const FrameTable frames(folder, manifest, state);
  WriteFrameTable(folder, manifest, frames);
  WriteReport(folder, manifest, state, frames, OwnPath());
  std::cout << fmt::format("{} frames\ntable  {}\nreport {}\n", frames.size(),
                           folder.table().string(), folder.report().string());
  if (state.missing > 0) {
    std::cerr << fmt::format("sprout-batch: {} of {} logs are missing; why: {}\n", state.missing,
                             manifest.log_size(), folder.failures().string());
    PrintTaskOutput(folder, std::cerr);
  } else if (frames.size() == 0) {
    std::cerr << "sprout-batch: no frame was answered in these logs; see sprout-log info, "
                 "--channel-prefix and --stages\n";
  } else {
    WarnOfEmptyLogs(manifest, state, frames);
  }
  const bool is_whole = state.missing == 0 && frames.size() > 0;
  return is_whole ? 0 : 1;
}

int RunRun(Options& options) {
  options.slurm.retries = options.local.retries;
  const BatchFolder folder = FolderOf(options.request.out);
  options.request.out = folder.root();
  const FolderLock lock(folder);
  const Interrupt interrupt;
  if (const std::string jobs = ActiveJobs(folder); !jobs.empty()) {
    throw ConfigError(fmt::format("--out {}: Slurm's jobs {} are there ({}); wait, or scancel {}",
                                  folder.root().string(), jobs, StatesOfJobs(jobs), jobs));
  }
  RemoveParts(folder);
  const Manifest manifest = Plan(options.request, OwnPath());
  const BatchState state = LinkAnswers(folder, manifest);
  std::cout << fmt::format("{} logs, {} of them to do\n", manifest.log_size(), state.missing);
  if (state.missing == 0) return Finish(folder, manifest, state);
  if (options.engine == "slurm") {
    std::cout << SubmitSlurm(OwnPath(), folder, state, options.slurm, 0) << "\n"
              << "sprout-batch status " << ShellWord(folder.root().string())
              << " shows the progress\n";
    return 0;
  }
  RunLocal(OwnPath(), folder, state, options.local);
  return Finish(folder, manifest, LinkAnswers(folder, manifest));
}

int RunCompute(const Options& options) {
  const BatchFolder folder(options.out);
  const Manifest manifest = ReadManifest(folder.manifest());
  int exit_code = 0;
  for (const size_t log : options.logs) {
    if (log >= static_cast<size_t>(manifest.log_size())) {
      throw ConfigError(fmt::format("{}: has no log {}", folder.manifest().string(), log));
    }
    try {
      RunLog(folder, manifest, static_cast<int>(log), options.threads);
    } catch (const ConfigError&) {
      throw;
    } catch (const std::runtime_error& e) {  // the other logs are still computed
      std::cerr << "sprout-batch: " << e.what() << "\n";
      exit_code = 1;
    }
  }
  return exit_code;
}

int RunFinish(const Options& options) {
  const BatchFolder folder(options.out);
  const Manifest manifest = ReadManifest(folder.manifest());
  const BatchState state = LinkAnswers(folder, manifest);
  if (state.missing > 0 && options.round < options.slurm.retries) {
    std::cout << SubmitSlurm(OwnPath(), folder, state, options.slurm, options.round + 1) << "\n";
  }
  return Finish(folder, manifest, state);
}

int RunStatus(const Options& options) {
  const BatchFolder folder = FolderOf(options.out);
  const Manifest manifest = ReadManifest(folder.manifest());
  const BatchState state = StateOf(folder, manifest);
  std::cout << fmt::format("{} of {} logs are done\n", manifest.log_size() - state.missing,
                           manifest.log_size());
  for (const auto& [log, tries] : FailedTries(folder)) {
    if (log < 0 || log >= manifest.log_size()) continue;
    std::cout << fmt::format(
        "{}: {}: {}\n", manifest.log(log).name(),
        state.done[static_cast<size_t>(log)] ? "is done after a failure" : "failed or is running",
        TryPath(folder, log, tries).string());
  }
  const std::string jobs = ActiveJobs(folder);
  if (!jobs.empty()) std::cout << "Slurm's jobs " << jobs << ": " << StatesOfJobs(jobs) << "\n";
  if (state.missing > 0) PrintTaskOutput(folder, std::cout);
  return state.missing == 0 ? 0 : 1;
}

int RunReport(const Options& options) {
  const BatchFolder folder = FolderOf(options.out);
  const Manifest manifest = ReadManifest(folder.manifest());
  return Finish(folder, manifest, LinkAnswers(folder, manifest));
}

constexpr char kDescription[] =
    "Replays stages on many logs, on all cores or with Slurm, compares two configurations or\n"
    "two builds frame by frame, and writes a table and a report.";

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
  flags.Add("--stages", request.stages, "Stages to run, of refine,prior,grow,temporal")
      .Repeatable()
      .SplitAtCommas()
      .ShowDefault();
  flags
      .Add("--config FILE|PRESET", request.config_a,
           "Configuration A, as for the services; several are merged")
      .Repeatable();
  flags.Add("--config-b FILE|PRESET", request.config_b, "Configuration B, to compare with A")
      .Repeatable();
  flags.Add("--programs-b", request.programs_b,
            "Folder of B's programs, to compare with another build; A's are beside sprout-batch");
  flags.Add("--channel-prefix", request.prefix, "Prefix of every channel of the logs");
  Flag engine = flags.Add("--engine", options.engine, "Where to compute");
  engine.OneOf({"local", "slurm"}).ShowDefault();
  flags.Add("--jobs", options.local.jobs, "local: logs at a time, 0 = one a core")
      .WithinWhole(0, 4096)
      .ShowDefault();
  flags.Add("--retries", options.local.retries, "How often a failed log is tried again")
      .WithinWhole(0, 100)
      .ShowDefault();
  AddSlurm(flags, options.slurm);
  for (const char* name : {"--partition", "--memory", "--time", "--array-size"}) {
    flags.Get(name).Needs(engine);
  }
}

void AddOthers(Flags& program, Options& options) {
  const auto add = [&](const char* name, const char* text, int (*run)(const Options&)) -> Flags& {
    Flags& flags = program.AddCommand(name, text, [&options, run] { return run(options); });
    flags.Add("OUT", options.out, "Folder of the batch").Required();
    return flags;
  };
  add("status", "Progress of a batch", RunStatus);
  add("report", "Writes table and report of the finished logs", RunReport);
  Flags& compute = add("compute", "Computes logs; called by both engines", RunCompute);
  compute.Add("LOG", options.logs, "Numbers of logs").Required();
  compute.Add("--threads", options.threads, "Threads of a stage")
      .WithinWhole(1, kMaxThreads)
      .ShowDefault();
  Flags& finish =
      add("finish", "Slurm's last job: as report, and submits missing logs again", RunFinish);
  finish.Add("--round", options.round, "Number of the submission").ShowDefault();
  finish.Add("--retries", options.slurm.retries, "Most rounds").ShowDefault();
  AddSlurm(finish, options.slurm);
}

int Main(int argc, char** argv) {
  Flags program("sprout-batch", kDescription);
  program.SetFooter(kFooter);
  program.RequireCommand();
  Options options;
  AddRun(program, options);
  AddOthers(program, options);
  return RunProgram(program, argc, argv, [&] {
    try {
      return RefusingLogs([&] { return program.RunCommand(); });
    } catch (const Interrupted& e) {
      std::cerr << "sprout-batch: " << e.what() << "; the same command continues from here\n";
      return 130;
    }
  });
}

}  // namespace
}  // namespace sprout::batch

int main(int argc, char** argv) { return sprout::batch::Main(argc, argv); }
