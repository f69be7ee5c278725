#ifndef SPROUT_COMMON_CORE_OUTPUT_FILE_H_
#define SPROUT_COMMON_CORE_OUTPUT_FILE_H_

#include <filesystem>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "common/core/result.h"

namespace sprout {

/// A file that appears whole or not at all: it grows as `PATH.part` and gets its name when
/// Commit() succeeds; until then an older file of that name stays as it was. Without Commit() the
/// part is removed.
///
/// Only a regular file is replaced. /dev/stdout, /dev/stderr, /dev/fd/N and character devices such
/// as /dev/null are written through. Whatever else has the name (a folder, a link, a FIFO, a disk)
/// is refused and stays as it is.
class OutputFile {
 public:
  /// Opens `PATH.part`; when there is one already, which may be anybody's, `PATH.part2` and so on.
  /// The directory must exist. A failure shows in failure() and Commit().
  explicit OutputFile(std::filesystem::path path);
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  /// Whether there is a file that Commit() will replace.
  bool replaces() const { return replaces_; }

  /// Appends bytes through a buffer; does nothing once something failed.
  void Write(std::string_view bytes);

  /// Appends the bytes of a number as they lie in memory: little-endian.
  template <typename T>
  void WriteNumber(T number) {
    static_assert(std::is_arithmetic_v<T>);
    Write({reinterpret_cast<const char*>(&number), sizeof number});
  }

  /// The reason of the first failure; empty: none so far. A full disk shows when the buffer of 1 MB
  /// is emptied.
  const std::string& failure() const { return failure_; }

  /// Writes what is left and gives the file its name. Call once, at the end.
  /// @returns the path and the reason when any step failed; nothing is left behind then.
  [[nodiscard]] Result<void> Commit();

 private:
  void OpenPart();
  void RemovePart();
  void WriteOut(std::string_view bytes);
  void Flush();
  void FailWithErrno();

  std::filesystem::path path_;
  std::filesystem::path part_path_;  // empty: written through
  int descriptor_ = -1;
  bool replaces_ = false;
  std::string failure_;
  std::vector<char> buffer_;
};

}  // namespace sprout

#endif  // SPROUT_COMMON_CORE_OUTPUT_FILE_H_
