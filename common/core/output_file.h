#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "common/core/result.h"

namespace sprout {

/// A file that is complete or not there: it is written without a name, named and put in place by
/// Commit(); until then an older file of that name stays. Without Commit(), also when the process
/// is killed, nothing is left. On file systems without nameless files (O_TMPFILE) it is written as
/// `PATH.part`, or `PATH.part2` and so on if that exists, which a kill leaves.
///
/// Only a regular file is replaced, and none that this program reads (see input_files.h). To
/// /dev/stdout, /dev/stderr, /dev/fd/N and character devices such as /dev/null bytes are written
/// directly. Anything else of that name (a folder, a link, a FIFO, a disk) is refused and stays.
class OutputFile {
 public:
  /// Whether a file that the program has read may be replaced.
  enum class OverInput { kRefused, kAllowed };

  /// The directory must exist. Errors are returned by failure() and Commit().
  explicit OutputFile(std::filesystem::path path, OverInput over_input = OverInput::kRefused);
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  /// Whether there is a file that Commit() will replace.
  bool replaces() const { return replaces_; }

  /// Appends bytes through a buffer; does nothing after a failure.
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

  /// Writes the rest and renames the file. Call once, at the end.
  /// @returns the path and the reason when any step failed; nothing is left behind then.
  [[nodiscard]] Result<void> Commit();

 private:
  std::string Obstacle() const;
  void OpenPart();
  template <typename Make>
  void MakePart(const Make& make);
  void RemovePart();
  void WriteOut(std::string_view bytes);
  void Flush();
  void FailWithErrno();

  std::filesystem::path path_;
  std::filesystem::path part_path_;  // empty: has no name, or is written directly
  bool is_nameless_ = false;
  int descriptor_ = -1;
  bool replaces_ = false;
  OverInput over_input_;
  std::string failure_;
  std::vector<char> buffer_;
};

}  // namespace sprout
