#include "services/tools/batch/log_task.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/stat.h>

#include <cerrno>
#include <chrono>
#include <memory>
#include <system_error>

#include "common/app/compute.h"
#include "common/app/process.h"
#include "common/core/host_name.h"
#include "common/core/printable.h"
#include "common/logfile/log_error.h"
#include "services/tools/batch/answers.h"
#include "services/tools/batch/log_try.h"
#include "services/tools/batch/measures.h"
#include "services/tools/batch/result_folder.h"
#include "services/tools/batch/stage_runs.h"

namespace sprout::batch {
namespace {

namespace fs = std::filesystem;

constexpr std::chrono::hours kPatience{24};

// Behind a colon; a program says last why it ends.
std::string LastLineOf(const std::string& output) {
  const size_t end = output.find_last_not_of('\n');
  if (end == std::string::npos) return "";
  const size_t before = output.find_last_of('\n', end);
  const size_t begin = before == std::string::npos ? 0 : before + 1;
  return ": " + output.substr(begin, end + 1 - begin);
}

class LogTask {
 public:
  LogTask(const BatchFolder& folder, const Manifest& manifest, int log, int threads,
          LogTry& attempt)
      : folder_(folder),
        manifest_(manifest),
        number_(log),
        log_(manifest.log(log)),
        threads_(threads),
        attempt_(attempt) {}

  void Run() {
    for (int i = 0; i < manifest_.variant_size(); ++i) {
      if (!IsWhole(ResultOf(i), ResultCheck::kQuick)) RunVariant(i);
    }
    if (Compares(manifest_)) CompareVariants();
  }

 private:
  fs::path ResultOf(int variant) const { return folder_.result(manifest_, number_, variant); }

  SproutConfig ConfigOf(int variant) const { return LoadConfig({folder_.config(variant)}); }

  void RunVariant(int variant) {
    RequirePlanned(variant);
    ResultFolder result(ResultOf(variant));
    std::vector<std::string> logs = {log_.path()};
    StageRuns runs;
    runs.set_host(Printable(HostName()));
    bool is_answered = true;
    for (int i = 0; is_answered && i < manifest_.stage_size(); ++i) {
      const std::string record = result / (manifest_.stage(i) + ".lcm");
      is_answered = RunStage(variant, i, logs, record, *runs.add_run());
      logs.push_back(record);
    }
    while (runs.run_size() < manifest_.stage_size()) runs.add_run();
    if (is_answered) {
      WriteTable(result / kMeasures, MeasureAnswers(manifest_, ConfigOf(variant), logs));
      KeepAnswers(result);
    } else {
      WriteTable(result / kMeasures, Table::Of(MeasureColumns()));
    }
    RequireUnchanged();
    WriteText(result / kRuns, ConfigText(runs));
    result.Commit();
  }

  void RequirePlanned(int variant) const {
    RequireUnchanged();
    if (FileDigest(folder_.config(variant)) != manifest_.variant(variant).config_digest()) {
      throw ConfigError(folder_.config(variant).string() +
                        ": not the configuration that the batch was planned with; run "
                        "sprout-batch run again");
    }
    for (const StageProgram& program : manifest_.variant(variant).program()) {
      if (FileDigest(program.path()) == program.digest()) continue;
      throw ConfigError(program.path() +
                        ": not the program that the batch was planned with; run sprout-batch run "
                        "again");
    }
  }

  void RequireUnchanged() const {
    if (StampOf(log_.path()) == FileStamp{log_.bytes(), log_.mtime_ns()}) return;
    throw LogError(log_.path(),
                   "has changed since the batch was planned; run sprout-batch run "
                   "again");
  }

  // @param logs  the input of the batch, and what the stages before answered.
  // @returns false when the log has no complete frame, so there is nothing to answer.
  bool RunStage(int variant, int stage, const std::vector<std::string>& logs,
                const std::string& record, StageRun& run) {
    std::vector<std::string> command = {manifest_.variant(variant).program(stage).path(),
                                        "--config",
                                        folder_.config(variant),
                                        "--threads",
                                        std::to_string(threads_),
                                        "--log-level",
                                        "warning",
                                        "--record",
                                        record};
    for (const std::string& log : logs) command.insert(command.end(), {"--replay", log});
    if (!manifest_.channel_prefix().empty()) {
      command.insert(command.end(), {"--channel-prefix", manifest_.channel_prefix()});
    }
    const auto start = std::chrono::steady_clock::now();
    Process process(command);
    const int code = process.Wait(kPatience).value_or(124);
    const std::string output = process.Output();
    if (code == 2 && stage == 0 && CountWithoutFrames(manifest_, log_, ConfigOf(variant), run))
      return false;
    // 1: all that can be answered is; how much was not is counted.
    if (code > 1 || output.find("stopped after") != std::string::npos) Fail(command, code, output);
    const std::optional<StageRun> counts = ParseReplayReport(output);
    if (!counts) Fail(command, code, output);
    run = *counts;
    run.set_seconds(
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
    return true;
  }

  [[noreturn]] void Fail(const std::vector<std::string>& command, int code,
                         const std::string& output) const {
    const std::string what =
        fmt::format("log {}, {}: {} ended with exit code {}{}", number_, log_.path(),
                    fs::path(command[0]).filename().string(), code, LastLineOf(output));
    attempt_.Fail(fmt::format("{}\n{}\n{}", what, fmt::join(command, " "), output));
    throw TaskError(what);
  }

  // The answers of the kept stages in one log; the others go.
  void KeepAnswers(const ResultFolder& result) const {
    std::vector<std::string> kept;
    for (const std::string& stage : manifest_.keep()) kept.push_back(result / (stage + ".lcm"));
    if (kept.size() == 1) {
      fs::rename(kept[0], result / kAnswers);
    } else {
      MergeLogs(kept, result / kAnswers);
    }
    for (const std::string& stage : manifest_.stage()) fs::remove(result / (stage + ".lcm"));
  }

  void CompareVariants() const {
    const fs::path path = folder_.comparison(manifest_, number_);
    if (IsWhole(path, ResultCheck::kQuick)) return;
    std::vector<std::unique_ptr<FrameLookup>> answers;
    for (int i = 0; i < manifest_.variant_size(); ++i) {
      answers.push_back(std::make_unique<FrameLookup>(manifest_.channel_prefix()));
      const fs::path log = ResultOf(i) / kAnswers;
      if (fs::exists(log)) answers.back()->Add(log);
    }
    const fs::path truth =
        manifest_.truth().empty() ? fs::path() : fs::path(manifest_.truth()) / log_.name();
    ResultFolder result(path);
    WriteTable(result / kChanges,
               CompareFrames(*answers[0], answers.size() > 1 ? answers[1].get() : nullptr,
                             AnswerOf(*manifest_.stage().rbegin()), truth));
    result.Commit();
  }

  const BatchFolder& folder_;
  const Manifest& manifest_;
  int number_;
  const BatchLog& log_;
  int threads_;
  LogTry& attempt_;
};

}  // namespace

FileStamp StampOf(const fs::path& log) {
  struct stat status {};
  if (stat(log.c_str(), &status) != 0) {
    throw LogError(log, std::generic_category().message(errno));
  }
  return {.bytes = status.st_size,
          .mtime_ns = status.st_mtim.tv_sec * int64_t{1'000'000'000} + status.st_mtim.tv_nsec};
}

void RunLog(const BatchFolder& folder, const Manifest& manifest, int log, int threads) {
  SetThreads(threads);
  KeepMemory();
  LogTry attempt(folder, log);
  try {
    LogTask(folder, manifest, log, threads, attempt).Run();
  } catch (const std::exception& e) {
    attempt.Fail(e.what());
    throw;
  }
}

}  // namespace sprout::batch
