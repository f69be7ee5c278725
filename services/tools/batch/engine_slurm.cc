#include <fmt/core.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "common/app/process.h"
#include "common/config/config_error.h"
#include "common/core/joined.h"
#include "common/core/number_text.h"
#include "common/core/printable.h"
#include "services/tools/batch/engines.h"

namespace sprout::batch {
namespace {

namespace fs = std::filesystem;

fs::path SlurmFolder(const BatchFolder& folder) { return folder.root() / "slurm"; }

// Writes the numbers of each task's logs, a line a task. Logs are dealt out in turn, so that tasks
// take about equally long.
int WriteTasks(const fs::path& path, const BatchState& state, int array_size) {
  std::vector<std::string> tasks;
  tasks.resize(static_cast<size_t>(std::min(state.missing, array_size)));
  size_t next = 0;
  for (size_t i = 0; i < state.done.size(); ++i) {
    if (!state.done[i]) tasks[next++ % tasks.size()] += fmt::format("{} ", i);
  }
  std::string text;
  for (const std::string& task : tasks) text += task + "\n";
  WriteText(path, text);
  return static_cast<int>(tasks.size());
}

std::string Sbatch(const fs::path& script, const std::vector<std::string>& flags) {
  std::vector<std::string> command = {"sbatch", "--parsable"};
  command.insert(command.end(), flags.begin(), flags.end());
  command.push_back(script);
  Process process(command);
  const auto code = process.Wait(std::chrono::seconds(120));
  const std::string output = process.Output();
  const std::string id = Joined("; ", SplitAt('\n', Trimmed(output)));
  if (code != 0) {
    throw ConfigError("sbatch: " + (code == 127 ? "not found; is Slurm installed here?" : id));
  }
  return id.substr(0, id.find_first_not_of("0123456789"));  // "12;cluster"
}

// @param name  in which Slurm replaces "%j" and its like; in the folder's name '%' is escaped.
std::string OutputFlag(const fs::path& folder, const std::string& name) {
  std::string flag = "--output=";
  for (const char letter : folder.string()) flag += letter == '%' ? "%%" : std::string(1, letter);
  return flag + "/" + name;
}

// Submits a job that begins when another one has ended.
std::string SbatchAfter(const std::string& job, const fs::path& script,
                        const std::vector<std::string>& flags) {
  try {
    return Sbatch(script, flags);
  } catch (const ConfigError& e) {
    throw ConfigError(
        fmt::format("{}; job {} computes all the same: when it has ended, the same "
                    "command writes table and report, or scancel {}",
                    e.what(), job, job));
  }
}

std::vector<std::string> SbatchFlags(const BatchFolder& folder, const SlurmOptions& options,
                                     const std::string& name) {
  std::vector<std::string> flags = {"--job-name=sprout-batch-" + name,
                                    "--ntasks=1",
                                    "--cpus-per-task=1",
                                    "--mem=" + options.memory,
                                    "--time=" + options.time,
                                    "--requeue",
                                    "--open-mode=append",
                                    "--chdir=" + folder.root().string()};
  if (!options.partition.empty()) flags.push_back("--partition=" + options.partition);
  return flags;
}

}  // namespace

std::string ActiveJobs(const BatchFolder& folder) {
  const std::string jobs = FirstLineOf(SlurmFolder(folder) / "jobs");
  std::vector<std::string_view> active;
  for (const std::string_view job : SplitAt(',', jobs)) {
    if (job.empty()) continue;
    Process process({"squeue", "--noheader", "--format=%i", "--jobs=" + std::string(job)});
    const bool known = process.Wait(std::chrono::seconds(60)) == 0;  // not when it is long over
    const bool has_number = process.Output().find_first_of("0123456789") != std::string::npos;
    if (known && has_number) active.push_back(job);
  }
  return Joined(",", active);
}

std::string StatesOfJobs(const std::string& jobs) {
  Process process({"squeue", "--noheader", "--format=%T (%r)", "--jobs=" + jobs});
  process.Wait(std::chrono::seconds(60));
  std::map<std::string, int> states;
  std::istringstream lines(process.Output());
  for (std::string state; std::getline(lines, state);) {
    constexpr std::string_view kNoReason = " (None)";
    if (state.ends_with(kNoReason)) state.resize(state.size() - kNoReason.size());
    ++states[Printable(state)];
  }
  return Joined(", ", states,
                [](const auto& state) { return fmt::format("{} {}", state.second, state.first); });
}

std::string TaskOutput(const BatchFolder& folder) {
  std::error_code none;
  fs::path newest;
  for (const fs::directory_entry& entry : fs::directory_iterator(SlurmFolder(folder), none)) {
    const bool is_of_task = entry.path().filename().string().starts_with("compute_");
    if (!is_of_task || entry.file_size() == 0) continue;
    if (newest.empty() || fs::last_write_time(newest) < entry.last_write_time()) {
      newest = entry.path();
    }
  }
  if (newest.empty()) return "";
  std::ifstream lines(newest);
  std::string last;
  for (std::string line; std::getline(lines, line);) last = line;
  return newest.string() + ": " + Printable(last);
}

std::string SubmitSlurm(const std::string& program, const BatchFolder& folder,
                        const BatchState& state, const SlurmOptions& options, int round) {
  const fs::path slurm = SlurmFolder(folder);
  fs::create_directories(slurm);
  const std::string root = ShellWord(folder.root().string());
  const fs::path tasks = slurm / fmt::format("tasks{}", round);
  const int count = WriteTasks(tasks, state, options.array_size);
  const std::string run = "#!/bin/sh\nexec " + ShellWord(program);

  const fs::path compute = slurm / fmt::format("compute{}.sh", round);
  WriteText(compute, fmt::format("{} compute {} $(sed -n \"$((SLURM_ARRAY_TASK_ID + 1))p\" {})\n",
                                 run, root, ShellWord(tasks.string())));
  const fs::path finish = slurm / fmt::format("finish{}.sh", round);
  WriteText(
      finish,
      fmt::format("{} finish {} --round {} --retries {} --memory={} --time={} --array-size={}{}\n",
                  run, root, round, options.retries, ShellWord(options.memory),
                  ShellWord(options.time), options.array_size,
                  options.partition.empty() ? "" : " --partition=" + ShellWord(options.partition)));

  auto flags = SbatchFlags(folder, options, "compute");
  flags.push_back(fmt::format("--array=0-{}", count - 1));
  flags.push_back(OutputFlag(slurm, "compute_%A_%a.txt"));
  const std::string array_job = Sbatch(compute, flags);
  WriteText(slurm / "jobs", array_job + "\n");  // also if the next one is refused
  flags = SbatchFlags(folder, options, "finish");
  flags.push_back("--dependency=afterany:" + array_job);
  flags.push_back(OutputFlag(slurm, "finish_%j.txt"));
  const std::string finish_job = SbatchAfter(array_job, finish, flags);
  WriteText(slurm / "jobs", array_job + "," + finish_job + "\n");
  return fmt::format("submitted: {} logs in the {} tasks of job {}, then table and report ({})",
                     state.missing, count, array_job, finish_job);
}

}  // namespace sprout::batch
