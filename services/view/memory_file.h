#ifndef SPROUT_SERVICES_VIEW_MEMORY_FILE_H_
#define SPROUT_SERVICES_VIEW_MEMORY_FILE_H_

#include <filesystem>

namespace sprout::view {

/// A file without a name, in memory: what writes files can write what is sent to a browser.
class MemoryFile {
 public:
  /// @throws std::system_error when the kernel has none left.
  MemoryFile();
  ~MemoryFile();
  MemoryFile(MemoryFile&& other) noexcept;
  MemoryFile& operator=(MemoryFile&&) = delete;

  /// To write it, once; see OutputFile.
  std::filesystem::path path() const;

  /// Its own descriptor, at the beginning of the file; the caller closes it.
  int OpenForReading() const;

 private:
  int descriptor_ = -1;
};

}  // namespace sprout::view

#endif  // SPROUT_SERVICES_VIEW_MEMORY_FILE_H_
