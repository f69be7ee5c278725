#include "services/tools/batch/commands.h"

#include <fcntl.h>
#include <fmt/core.h>
#include <sys/file.h>
#include <unistd.h>

#include <filesystem>
#include <iostream>

#include "common/core/interrupt.h"
#include "common/core/shell_word.h"
#include "services/tools/batch/frame_table.h"
#include "services/tools/batch/log_task.h"
#include "services/tools/batch/log_try.h"
#include "services/tools/batch/report.h"

namespace sprout::batch {
namespace {

namespace fs = std::filesystem;

std::string OwnPath() { return fs::read_symlink("/proc/self/exe"); }

BatchFolder FolderOf(const std::string& out) {
  return BatchFolder(fs::absolute(out).lexically_normal());
}

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

// Writes table and report.
int Finish(const BatchFolder& folder, const Manifest& manifest, const BatchState& state) {
  const FrameTable frames(folder, manifest, state);
  WriteFrameTable(folder, manifest, frames);
  WriteReport(folder, manifest, state, frames, OwnPath());
  std::cout << fmt::format("{} frames\ntable  {}\nreport {}\n", frames.size(),
                           folder.table().string(), folder.report().string());
  if (state.missing > 0) {
    std::cerr << fmt::format("sprout-batch: {} of {} logs are missing; why: {}\n", state.missing,
                             manifest.log_size(), folder.failures().string());
  } else if (frames.size() == 0) {
    std::cerr << "sprout-batch: no frame was answered in these logs; see sprout-log info, "
                 "--channel-prefix and --stages\n";
  }
  return state.missing == 0 && frames.size() > 0 && manifest.left_out().empty() ? 0 : 1;
}

}  // namespace

int RunRun(Options& options) {
  options.slurm.retries = options.local.retries;
  const BatchFolder folder = FolderOf(options.request.out);
  options.request.out = folder.root();
  if (options.request.programs_a.empty()) {
    options.request.programs_a = fs::path(OwnPath()).parent_path();
  }
  const FolderLock lock(folder);
  const Interrupt interrupt;
  if (const std::string jobs = ActiveJobs(folder); !jobs.empty()) {
    throw ConfigError(
        fmt::format("--out {}: Slurm's jobs {} are running there; wait, or scancel {}",
                    folder.root().string(), jobs, jobs));
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
    } catch (const std::runtime_error& e) {  // the others are still worth doing
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
  SayLeftOut(manifest);
  const std::string jobs = ActiveJobs(folder);
  if (!jobs.empty()) std::cout << "Slurm's jobs " << jobs << " are running\n";
  return state.missing == 0 && manifest.left_out().empty() ? 0 : 1;
}

int RunReport(const Options& options) {
  const BatchFolder folder = FolderOf(options.out);
  const Manifest manifest = ReadManifest(folder.manifest());
  return Finish(folder, manifest, LinkAnswers(folder, manifest));
}

}  // namespace sprout::batch
