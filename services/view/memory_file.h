#ifndef SPROUT_SERVICES_VIEW_MEMORY_FILE_H_
#define SPROUT_SERVICES_VIEW_MEMORY_FILE_H_

#include <filesystem>

namespace sprout::view {

/// An unnamed file in memory: lets functions that write files produce what is sent to a browser.
class MemoryFile {
 public:
  /// @throws std::system_error when it cannot be created.
  MemoryFile();
  ~MemoryFile();
  MemoryFile(MemoryFile&& other) noexcept;
  MemoryFile& operator=(MemoryFile&&) = delete;

  /// Path for writing it, once; see OutputFile.
  std::filesystem::path path() const;

  /// A new descriptor, at the beginning of the file; the caller closes it.
  int OpenForReading() const;

 private:
  int descriptor_ = -1;
};

}  // namespace sprout::view

#endif  // SPROUT_SERVICES_VIEW_MEMORY_FILE_H_
