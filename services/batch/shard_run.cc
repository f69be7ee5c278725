#include "services/batch/shard_run.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <chrono>
#include <memory>
#include <regex>

#include "common/app/compute.h"
#include "common/app/process.h"
#include "common/config/stage_parts.h"
#include "common/core/printable.h"
#include "common/logfile/log_error.h"
#include "services/batch/names.h"
#include "services/batch/result_folder.h"
#include "services/batch/scratch_file.h"
#include "services/batch/shard_input.h"
#include "services/batch/shard_try.h"
#include "services/batch/stage_run.h"
#include "services/batch/tables.h"

namespace sprout::batch {
namespace {

namespace fs = std::filesystem;

constexpr std::chrono::hours kPatience{24};

// Scratch files have names that say nothing.
std::string WithFolderOfScratch(const std::string& text) {
  static const std::regex kScratch("/dev/fd/[0-9]+");
  return std::regex_replace(text, kScratch,
                            "scratch file in " + fs::temp_directory_path().string());
}

// Behind a colon; a program says last why it ends.
std::string LastLineOf(const std::string& output) {
  const size_t end = output.find_last_not_of('\n');
  if (end == std::string::npos) return "";
  const size_t before = output.find_last_of('\n', end);
  const size_t begin = before == std::string::npos ? 0 : before + 1;
  return ": " + output.substr(begin, end + 1 - begin);
}

class ShardRun {
 public:
  ShardRun(const BatchFolder& folder, size_t number, ShardTry& attempt)
      : folder_(folder),
        number_(number),
        attempt_(attempt),
        work_(ReadShard(folder.manifest(), number)),
        channels_(Channels()) {}

  void Run() {
    for (const Variant& variant : work_.head.variants) {
      if (!IsWhole(folder_.result(KeyOf(variant)), ResultCheck::kQuick)) RunVariant(variant);
    }
    if (Compares(work_.head)) Compare();
  }

 private:
  std::vector<std::string> Channels() const {
    return ChannelsOf(InputsOf(work_.head.stages, LoadConfig({folder_.config("a")})),
                      work_.head.prefix);
  }

  std::string KeyOf(const Variant& variant) const {
    return ResultKey(work_.head, variant, work_.shard);
  }

  ShardInput& Input() {
    try {
      if (!input_) input_.emplace(work_, channels_);
      return *input_;
    } catch (const LogError& e) {
      throw ShardError(WithFolderOfScratch(e.what()));
    }
  }

  void RunVariant(const Variant& variant) {
    RequirePrograms(variant);
    ResultFolder result(folder_.result(KeyOf(variant)));
    std::vector<std::string> logs = {Input().path()};
    std::vector<std::unique_ptr<ScratchFile>> scratch;
    StageRuns runs;
    for (const std::string& stage : work_.head.stages) {
      const auto& keep = work_.head.keep;
      std::string record = result / (stage + ".lcm");
      if (std::find(keep.begin(), keep.end(), stage) == keep.end()) {
        record = scratch.emplace_back(std::make_unique<ScratchFile>())->path();
      }
      runs[stage] = RunStageProgram(variant, stage, logs, record);
      logs.push_back(record);
    }
    WriteTable(result / kMeasures, MeasuresOf(logs));
    input_->RequireUnchanged();
    WriteStageRuns(result / kRuns, runs);
    result.Commit();
  }

  // @param logs  the shard, and what each stage answered.
  Table MeasuresOf(const std::vector<std::string>& logs) {
    const BatchHead& head = work_.head;
    const Part answer = AnswerOf(head.stages.back());
    FrameLookup frames(head.prefix);
    if (!head.measured) {
      frames.Add(logs.back());
      return ListFrames(frames, answer);
    }
    input_->AddTo(frames);
    const SproutConfig config = LoadConfig({folder_.config("a")});
    for (size_t i = 0; i < head.stages.size(); ++i) {
      if (IsMeasured(OutputsOf(head.stages[i], config), answer)) frames.Add(logs[i + 1]);
    }
    return MeasureFrames(frames, answer);
  }

  static void RequirePrograms(const Variant& variant) {
    for (const auto& [stage, program] : variant.programs) {
      if (FileDigest(program.path) == program.digest) continue;
      throw ConfigError(program.path +
                        ": not the program that the batch was planned with; run sprout-batch run "
                        "again");
    }
  }

  StageRun RunStageProgram(const Variant& variant, const std::string& stage,
                           const std::vector<std::string>& logs, const std::string& record) {
    std::vector<std::string> command = {variant.programs.at(stage).path,
                                        "--config",
                                        folder_.config(variant.name),
                                        "--threads",
                                        "1",
                                        "--log-level",
                                        "warning",
                                        "--record",
                                        record};
    for (const std::string& log : logs) command.insert(command.end(), {"--replay", log});
    if (!work_.head.prefix.empty()) {
      command.insert(command.end(), {"--channel-prefix", work_.head.prefix});
    }
    const auto start = std::chrono::steady_clock::now();
    Process process(command);
    const int code = process.Wait(kPatience).value_or(124);
    const std::string output = process.Output();
    // 1: all that can be answered is, as in a replay of the whole log; how much was not is counted.
    if (code > 1 || output.find("stopped after") != std::string::npos) Fail(command, code, output);
    std::optional<StageRun> run = ParseReplayReport(output);
    if (!run) Fail(command, code, output);
    run->seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return *run;
  }

  [[noreturn]] void Fail(const std::vector<std::string>& command, int code,
                         const std::string& output) const {
    const std::string what = fmt::format(
        "shard {}, frames {}:{} of {}: {} ended with exit code {}{}", number_,
        work_.shard.first_seq, work_.shard.last_seq, work_.log.path,
        fs::path(command[0]).filename().string(), code, WithFolderOfScratch(LastLineOf(output)));
    attempt_.Fail(fmt::format("{}\n{}\n{}", what, fmt::join(command, " "), output));
    throw ShardError(what);
  }

  void Compare() {
    const fs::path path = folder_.comparison(ComparisonKey(work_.head, work_.log, work_.shard));
    if (IsWhole(path, ResultCheck::kQuick)) return;
    std::vector<std::unique_ptr<FrameLookup>> lookups;
    for (const Variant& variant : work_.head.variants) {
      lookups.push_back(std::make_unique<FrameLookup>(work_.head.prefix));
      lookups.back()->Add(folder_.result(KeyOf(variant)) / (work_.head.stages.back() + ".lcm"));
    }
    ResultFolder result(path);
    WriteTable(
        result / kChanges,
        CompareFrames(
            *lookups[0], lookups.size() > 1 ? lookups[1].get() : nullptr,
            AnswerOf(work_.head.stages.back()),
            work_.head.truth.empty() ? fs::path() : fs::path(work_.head.truth) / work_.log.name));
    result.Commit();
  }

  const BatchFolder& folder_;
  size_t number_;
  ShardTry& attempt_;
  ShardOfBatch work_;
  std::vector<std::string> channels_;
  std::optional<ShardInput> input_;
};

}  // namespace

bool IsDone(const BatchFolder& folder, const BatchHead& head, const BatchLog& log,
            const Shard& shard, ResultCheck check) {
  const auto is_there = [&](const Variant& variant) {
    return IsWhole(folder.result(ResultKey(head, variant, shard)), check);
  };
  return std::all_of(head.variants.begin(), head.variants.end(), is_there) &&
         (!Compares(head) || IsWhole(folder.comparison(ComparisonKey(head, log, shard)), check));
}

StageProgram DescribeProgram(const std::string& path) {
  Process process({path, "--version"});
  if (process.Wait() != 0) throw ConfigError(path + ": cannot be run");
  std::string version = process.Output();
  while (!version.empty() && std::isspace(static_cast<unsigned char>(version.back())) != 0) {
    version.pop_back();
  }
  version = Printable(version);
  return {.path = path, .digest = FileDigest(path), .version = version};
}

void RunShard(const BatchFolder& folder, size_t number) {
  SetThreads(1);  // other shards have the other cores
  KeepMemory();
  ShardTry attempt(folder, number);
  try {
    ShardRun(folder, number, attempt).Run();
  } catch (const std::exception& e) {
    attempt.Fail(e.what());
    throw;
  }
}

}  // namespace sprout::batch
