#ifndef SPROUT_COMMON_PICTURE_OUTPUT_FILE_H_
#define SPROUT_COMMON_PICTURE_OUTPUT_FILE_H_

#include <cstdio>
#include <filesystem>
#include <memory>
#include <string_view>
#include <type_traits>
#include <vector>

#include "common/core/result.h"

namespace sprout {

/// A file that appears whole or not at all: it grows as `PATH.part` and gets its name when
/// Commit() succeeds; until then an older file of that name stays as it was. Without Commit() the
/// part is removed. Two writers must not write the same path at the same time.
class OutputFile {
 public:
  /// Opens `PATH.part`. The directory must exist. A failure is reported by Commit().
  explicit OutputFile(std::filesystem::path path);
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  /// Appends bytes through a buffer; does nothing once something failed.
  void Write(std::string_view bytes);

  /// Appends the bytes of a number as they lie in memory: little-endian.
  template <typename T>
  void WriteNumber(T number) {
    static_assert(std::is_arithmetic_v<T>);
    Write({reinterpret_cast<const char*>(&number), sizeof number});
  }

  /// Writes what is left and gives the file its name. Call once, at the end.
  /// @returns the path and the system's reason when any step failed; nothing is left behind then.
  [[nodiscard]] Result<void> Commit();

 private:
  void Flush();

  std::filesystem::path path_;
  std::filesystem::path part_path_;
  std::FILE* file_;
  int error_number_ = 0;  // errno of the first failure
  std::vector<char> buffer_;
};

}  // namespace sprout

#endif  // SPROUT_COMMON_PICTURE_OUTPUT_FILE_H_
