#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>

#include "services/tools/batch/manifest.h"

namespace sprout::batch {

/// Files of a result, and of a comparison. A result without a complete frame has no answers.
inline constexpr char kAnswers[] = "answers.lcm";
inline constexpr char kMeasures[] = "measures.csv";
inline constexpr char kRuns[] = "runs.textproto";
inline constexpr char kChanges[] = "changes.csv";

/// State of a log's file: shows whether a manifest still fits it.
struct FileStamp {
  int64_t bytes = 0;
  int64_t mtime_ns = 0;

  bool operator==(const FileStamp&) const = default;
};

/// @throws LogError when there is no such file.
FileStamp StampOf(const std::filesystem::path& log);

/// Computes the missing results of a log: replays it through the stages, measures their answers,
/// compares the variants. Results are renamed into place when complete, so concurrent or killed
/// processes do no harm.
/// @param log      its number in the manifest.
/// @param threads  of each stage.
/// @throws std::runtime_error when a stage failed, whose output is in failed/ of the batch;
///         LogError; ConfigError when a program or a configuration differs from the manifest's.
void RunLog(const BatchFolder& folder, const Manifest& manifest, int log, int threads);

/// One try to compute a log, which has a file failed/LOG.TRY.txt while it runs. The file is removed
/// when the try succeeds, and gets the reason when it fails. If the process is killed, or its
/// machine dies, the file stays, so such tries are counted, too.
class LogTry {
 public:
  /// @param log  its number in the manifest; below, too.
  LogTry(const BatchFolder& folder, int log);
  ~LogTry();
  LogTry(const LogTry&) = delete;
  LogTry& operator=(const LogTry&) = delete;

  /// Keeps the file, with this text. Only the first reason is kept.
  void Fail(const std::string& why);

 private:
  std::filesystem::path path_;
  bool failed_ = false;
};

/// Number of tries that did not succeed, by log; logs without such a try are left out. Running
/// tries are included. O(tries).
std::map<int, int> FailedTries(const BatchFolder& folder);

/// File of the last of them. @pre `tries` > 0, as FailedTries() says.
std::filesystem::path TryPath(const BatchFolder& folder, int log, int tries);

/// Does not count any try; other files stay.
void ForgetTries(const BatchFolder& folder);

/// Does not count the last try of a log, which was ended by Ctrl-C.
void ForgetTry(const BatchFolder& folder, int log);

}  // namespace sprout::batch
