#include "services/tools/batch/log_task.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <fstream>
#include <system_error>
#include <utility>
#include <vector>

#include "common/app/compute.h"
#include "common/app/process.h"
#include "common/config/stage_parts.h"
#include "common/core/host_name.h"
#include "common/core/number_text.h"
#include "common/core/printable.h"
#include "common/frames/log_frames.h"
#include "common/logfile/log_error.h"
#include "common/logfile/log_reader.h"
#include "services/tools/batch/frame_table.h"
#include "services/tools/batch/measures.h"
#include "services/tools/batch/result_folder.h"

namespace sprout::batch {
namespace {

// Measures what the stages of a batch answered, see MeasureFrames().
// @param logs  the input, and what each stage answered. @throws LogError.
Table MeasureAnswers(const Manifest& manifest, const SproutConfig& config,
                     const std::vector<std::string>& logs) {
  const Part answer = AnswerOf(*manifest.stage().rbegin());
  // What the stages took from the log, which may have recorded answers, too. LEFT is always read:
  // its position in the log goes into the table, for pictures.
  PartSet input = {Part::kLeft};
  PartSet answered;
  for (const std::string& stage : manifest.stage()) {
    for (const Part part : kAllParts) {
      if (!answered.Has(part) && InputsOf(stage, config).Has(part)) input.Add(part);
      if (OutputsOf(stage, config).Has(part)) answered.Add(part);
    }
  }
  FrameLookup frames(manifest.channel_prefix());
  frames.Add(logs[0], input);
  for (int i = 0; i < manifest.stage_size(); ++i) {
    const PartSet outputs = OutputsOf(manifest.stage(i), config);
    const bool is_needed = std::ranges::any_of(kAllParts, [&](Part part) {
      return outputs.Has(part) && (part == answer || MeasuredParts().Has(part));
    });
    if (is_needed) frames.Add(logs[static_cast<size_t>(i) + 1], outputs);
  }
  return MeasureFrames(frames, answer);
}

// Whether no frame of the log has all that the first stage needs; then counts what is missing.
// Reads the whole log. @throws LogError.
bool CountWithoutFrames(const Manifest& manifest, const BatchLog& log, const SproutConfig& config,
                        StageRun& run) {
  int64_t refused = 0;
  WholeFrames frames(log.path(), manifest.channel_prefix(), InputsOf(manifest.stage(0), config),
                     [&](const LogEvent&, const std::string&) { ++refused; });
  if (frames.Next()) return false;
  int64_t damaged = 0;
  for (const LogDamage& damage : frames.log().damage()) damaged += damage.bytes;
  run.set_incomplete(frames.joiner().incomplete());
  run.set_left_out(frames.joiner().sequence_gaps());
  run.set_bad_messages(refused);
  run.set_damaged_bytes(damaged);
  return true;
}

namespace fs = std::filesystem;

constexpr std::chrono::hours kPatience{24};

// The last line, in which a program says why it ends, after a colon.
std::string LastLineOf(const std::string& output) {
  const std::string_view text = Trimmed(output);
  return text.empty() ? "" : ": " + std::string(SplitAt('\n', text).back());
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
                   "has changed since the batch was planned; run sprout-batch run again");
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
    // With exit code 1 all frames that can be answered are, and the others are counted.
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
    throw std::runtime_error(what);
  }

  // Keeps the answers of the last stage, and deletes those of the others.
  void KeepAnswers(const ResultFolder& result) const {
    for (const std::string& stage : manifest_.stage()) {
      const fs::path answers = result / (stage + ".lcm");
      if (stage == *manifest_.stage().rbegin()) {
        fs::rename(answers, result / kAnswers);
      } else {
        fs::remove(answers);
      }
    }
  }

  void CompareVariants() const {
    const fs::path path = folder_.comparison(manifest_, number_);
    if (IsWhole(path, ResultCheck::kQuick)) return;
    const auto answers = [&](int variant) {
      FrameLookup lookup(manifest_.channel_prefix());
      const fs::path log = ResultOf(variant) / kAnswers;
      if (fs::exists(log)) lookup.Add(log);
      return lookup;
    };
    FrameLookup a = answers(0);
    FrameLookup b = answers(1);
    ResultFolder result(path);
    WriteTable(result / kChanges, CompareFrames(a, b, AnswerOf(*manifest_.stage().rbegin())));
    result.Commit();
  }

  const BatchFolder& folder_;
  const Manifest& manifest_;
  int number_;
  const BatchLog& log_;
  int threads_;
  LogTry& attempt_;
};

// The number in "LOG.TRY.txt"; nothing for other people's files.
std::optional<int> LogOfTry(const fs::directory_entry& file) {
  const fs::path name = file.path().filename();
  const fs::path numbers = name.stem();
  const std::string attempt = numbers.extension();
  const bool is_try = name.extension() == ".txt" && file.is_regular_file() && !attempt.empty() &&
                      ParseNumber<int>(std::string_view(attempt).substr(1));
  return is_try ? ParseNumber<int>(numbers.stem().string()) : std::nullopt;
}

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

LogTry::LogTry(const BatchFolder& folder, int log) {
  std::error_code ignored;
  std::filesystem::create_directories(folder.failures(), ignored);
  int descriptor = -1;
  for (int i = 1; descriptor < 0; ++i) {
    path_ = TryPath(folder, log, i);
    descriptor = open(path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (descriptor < 0 && errno != EEXIST) return;  // writing the results will fail and say why
  }
  close(descriptor);
  std::ofstream(path_) << fmt::format(
      "started on {} by process {}; if that is not running any more, it was killed\n", HostName(),
      getpid());
}

LogTry::~LogTry() {
  std::error_code ignored;
  if (!failed_) std::filesystem::remove(path_, ignored);
}

void LogTry::Fail(const std::string& why) {
  if (std::exchange(failed_, true)) return;
  std::ofstream(path_) << why << "\n";
}

std::filesystem::path TryPath(const BatchFolder& folder, int log, int tries) {
  return folder.failures() / fmt::format("{}.{}.txt", log, tries);
}

std::map<int, int> FailedTries(const BatchFolder& folder) {
  std::map<int, int> tries;
  std::error_code none;
  for (const auto& file : std::filesystem::directory_iterator(folder.failures(), none)) {
    if (const auto log = LogOfTry(file)) ++tries[*log];
  }
  return tries;
}

void ForgetTries(const BatchFolder& folder) {
  std::vector<std::filesystem::path> tries;
  std::error_code none;
  for (const auto& file : std::filesystem::directory_iterator(folder.failures(), none)) {
    if (LogOfTry(file)) tries.push_back(file.path());
  }
  for (const auto& path : tries) std::filesystem::remove(path);
  std::filesystem::remove(folder.failures(), none);  // only if no other file is in it
}

void ForgetTry(const BatchFolder& folder, int log) {
  const auto tries = FailedTries(folder);
  const auto found = tries.find(log);
  if (found != tries.end()) {
    std::filesystem::remove(TryPath(folder, log, found->second));
  }
}

}  // namespace sprout::batch
