#ifndef SPROUT_SERVICES_BATCH_RESULT_FOLDER_H_
#define SPROUT_SERVICES_BATCH_RESULT_FOLDER_H_

#include <filesystem>
#include <string>

namespace sprout::batch {

/// Digest of a file's bytes. @throws ConfigError when it cannot be read.
std::string FileDigest(const std::filesystem::path& path);

/// A folder that gets its name when all in it is written, with a list of its files, their sizes and
/// digests in it. Without Commit() nothing is left.
class ResultFolder {
 public:
  explicit ResultFolder(std::filesystem::path path);
  ~ResultFolder();
  ResultFolder(const ResultFolder&) = delete;
  ResultFolder& operator=(const ResultFolder&) = delete;

  std::filesystem::path operator/(const std::string& name) const { return part_ / name; }

  /// When another process was faster, its files stay; what is damaged is replaced.
  /// @throws LogError.
  void Commit();

 private:
  std::filesystem::path path_;
  std::filesystem::path part_;
};

/// What of the files of a result is looked at.
enum class ResultCheck {
  kQuick,  ///< bytes of tables and counts, sizes of logs
  kAll,    ///< every byte
};

/// Whether a result is there as it was written.
bool IsWhole(const std::filesystem::path& result, ResultCheck check);

/// A result that IsWhole() found damaged: from now on the quick look finds it, too.
void MarkDamaged(const std::filesystem::path& result);

/// Whether `path` is there as it was when MarkMadeFrom() was called with this source: as large, and
/// from the same.
bool IsMadeFrom(const std::filesystem::path& path, const std::string& source);

/// Writes PATH.source, which says what a file is made from. @throws LogError.
void MarkMadeFrom(const std::filesystem::path& path, const std::string& source);

/// The file is not whole until MarkMadeFrom() says so again.
void UnmarkMadeFrom(const std::filesystem::path& path);

}  // namespace sprout::batch

#endif  // SPROUT_SERVICES_BATCH_RESULT_FOLDER_H_
