#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/config/config.h"
#include "common/core/frame.h"
#include "services/tools/batch/manifest.pb.h"

namespace sprout::batch {

inline constexpr int kManifestFormat = 2;

/// @throws ConfigError, which names `flag`, unless the stages are some of refine, prior, grow and
///         temporal that follow each other in the graph.
void RequireStages(const std::string& flag, const std::vector<std::string>& stages);

/// What a stage always answers.
Part AnswerOf(const std::string& stage);

/// Paths of the files of a batch.
class BatchFolder {
 public:
  explicit BatchFolder(std::filesystem::path root) : root_(std::move(root)) {}

  const std::filesystem::path& root() const { return root_; }
  std::filesystem::path manifest() const { return root_ / "manifest.textproto"; }
  /// @param variant  0 is A, 1 is B; below, too.
  std::filesystem::path config(int variant) const;
  std::filesystem::path failures() const { return root_ / "failed"; }
  std::filesystem::path table() const { return root_ / "frames.csv"; }
  std::filesystem::path report() const { return root_ / "report.html"; }

  /// A link to the answers of a log.
  std::filesystem::path answers(const BatchLog& log, int variant) const;

  /// Folder of the answers to a log. Its name is the digest of the log, the stages, the programs
  /// and the configuration: equal names have equal results, also those of other batches.
  std::filesystem::path result(const Manifest& manifest, int log, int variant) const;

  /// Folder with the table of differences between the variants.
  std::filesystem::path comparison(const Manifest& manifest, int log) const;

 private:
  std::filesystem::path root_;
};

/// "a" or "b", in names of files and columns.
inline std::string VariantName(int variant) { return variant == 0 ? "a" : "b"; }

/// Whether there is something to compare: disparity maps of two variants.
bool Compares(const Manifest& manifest);

/// Reads a manifest, which may come from anywhere: every field is checked.
/// @throws ConfigError when there is none, or it is damaged or of another version: one line that
///         names field, value and what is allowed.
Manifest ReadManifest(const std::filesystem::path& path);

/// Writes a file, see OutputFile. @throws LogError, one line with the reason.
void WriteText(const std::filesystem::path& path, const std::string& text);

/// Empty where there is no such file.
std::string FirstLineOf(const std::filesystem::path& path);

}  // namespace sprout::batch
