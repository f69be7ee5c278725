#ifndef SPROUT_SERVICES_VIEW_SHARED_FILES_H_
#define SPROUT_SERVICES_VIEW_SHARED_FILES_H_

#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "common/core/result.h"

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

/// Files being sent to browsers. Each takes memory while it is read, and a browser that does not
/// read holds it for minutes, so their number is limited. Thread-safe.
class SharedFiles {
 public:
  using Clock = std::chrono::steady_clock;
  using File = std::shared_ptr<const MemoryFile>;
  using Write = std::function<Result<void>(const std::filesystem::path& path)>;

  /// Most readers at the same time.
  static constexpr long kMaxReaders = 2;

  /// How long a file is shared with later readers.
  static constexpr std::chrono::seconds kFresh{2};

  /// @param max_files  at the same time.
  explicit SharedFiles(size_t max_files) : max_files_(max_files) {}

  /// A file for one reader, valid as long as the pointer: one of the same name that is being read,
  /// or else a new one written by `write`.
  /// @returns null when there are too many.
  Result<File> Take(const std::string& name, Clock::time_point now, const Write& write);

 private:
  struct Entry {
    std::string name;
    Clock::time_point written;
    std::weak_ptr<const MemoryFile> file;
  };

  size_t max_files_;
  std::mutex mutex_;
  std::vector<Entry> entries_;
};

}  // namespace sprout::view

#endif  // SPROUT_SERVICES_VIEW_SHARED_FILES_H_
