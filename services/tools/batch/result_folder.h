#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "services/tools/batch/manifest.h"

namespace sprout::batch {

/// Digest of a file's bytes. @throws ConfigError when it cannot be read.
std::string FileDigest(const std::filesystem::path& path);

/// A folder that is renamed into place when all its files are written. It has a list of them with
/// sizes and digests. Without Commit() it is removed.
class ResultFolder {
 public:
  explicit ResultFolder(std::filesystem::path path);
  ~ResultFolder();
  ResultFolder(const ResultFolder&) = delete;
  ResultFolder& operator=(const ResultFolder&) = delete;

  std::filesystem::path operator/(const std::string& name) const { return part_ / name; }

  /// If another process was faster, its files stay; damaged ones are replaced.
  /// @throws LogError.
  void Commit();

 private:
  std::filesystem::path path_;
  std::filesystem::path part_;
};

/// How thoroughly the files of a result are checked.
enum class ResultCheck {
  kQuick,  ///< bytes of tables and counts, sizes of answers
  kAll,    ///< every byte
};

/// Whether a result is complete and unchanged.
bool IsWhole(const std::filesystem::path& result, ResultCheck check);

/// Marks a result that IsWhole() found damaged, so that the quick check finds it, too.
void MarkDamaged(const std::filesystem::path& result);

/// The counts that a stage printed at the end of a replay; nothing when it printed none.
std::optional<StageRun> ParseReplayReport(const std::string& output);

/// The counts of a result, one for each stage.
/// @throws LogError when they cannot be read, or lack a stage.
StageRuns ReadStageRuns(const std::filesystem::path& result, const Manifest& manifest);

/// Progress of a batch.
struct BatchState {
  std::vector<bool> done;  ///< by log
  int missing = 0;
};

/// Checks of every log whether its results exist and have their full sizes. O(logs).
BatchState StateOf(const BatchFolder& folder, const Manifest& manifest);

/// The same, and links logs/NAME_a.lcm and NAME_b.lcm to the answers of the logs that are done.
/// Answers that have no link yet are read for their digests: damaged ones do not count as done, and
/// lose their list of files, so that they are computed again; one line on stderr each. Links of an
/// earlier batch go.
/// @throws Interrupted; LogError when something else is in a link's place;
///         std::filesystem::filesystem_error when a link cannot be made.
BatchState LinkAnswers(const BatchFolder& folder, const Manifest& manifest);

/// Removes what killed processes left: folders that were not renamed yet.
void RemoveParts(const BatchFolder& folder);

}  // namespace sprout::batch
