#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

namespace sprout {

/// A regular file opened for reading. Its size is that at the time of opening, so a log that is
/// still being recorded looks like one with a torn tail.
///
/// Not mapped into memory: then a file shortened by another program would crash this process.
class InputFile {
 public:
  /// @throws LogError when there is no such file, or it is not seekable.
  explicit InputFile(std::filesystem::path path);
  ~InputFile();
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;

  const std::filesystem::path& path() const { return path_; }
  int64_t size() const { return size_; }

  /// Fills `bytes` from `offset` on. @throws LogError when that fails.
  void Read(int64_t offset, std::span<uint8_t> bytes) const;

 private:
  std::filesystem::path path_;
  int descriptor_;
  int64_t size_ = 0;
};

/// A moving window on a file: reads ahead and keeps recent bytes.
class FileWindow {
 public:
  /// @param chunk_bytes  least number of bytes to read at once; more are kept only for a longer
  ///                     view.
  FileWindow(const InputFile& file, int64_t chunk_bytes) : file_(file), chunk_bytes_(chunk_bytes) {}

  /// Up to `count` bytes from `offset` on, fewer at the end of the file; valid until the next call.
  /// @throws LogError.
  std::span<const uint8_t> View(int64_t offset, int64_t count);

  /// Whether View() would need no reading.
  bool Holds(int64_t offset, int64_t count) const;

 private:
  int64_t Clip(int64_t offset, int64_t count) const;

  const InputFile& file_;
  int64_t chunk_bytes_;
  std::vector<uint8_t> buffer_;
  int64_t start_ = 0;   // place in the file of buffer_[0]
  int64_t filled_ = 0;  // bytes in buffer_
};

}  // namespace sprout
