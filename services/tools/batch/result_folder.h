#ifndef SPROUT_SERVICES_TOOLS_BATCH_RESULT_FOLDER_H_
#define SPROUT_SERVICES_TOOLS_BATCH_RESULT_FOLDER_H_

#include <filesystem>
#include <string>

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

}  // namespace sprout::batch

#endif  // SPROUT_SERVICES_TOOLS_BATCH_RESULT_FOLDER_H_
