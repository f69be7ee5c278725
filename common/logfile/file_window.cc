#include "common/logfile/file_window.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <system_error>
#include <utility>

#include "common/core/input_files.h"
#include "common/logfile/log_error.h"

namespace sprout {
namespace {

std::string SystemReason() { return std::generic_category().message(errno); }

}  // namespace

InputFile::InputFile(std::filesystem::path path) : path_(std::move(path)) {
  descriptor_ = open(path_.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);  // a FIFO would wait
  if (descriptor_ < 0) throw LogError(path_, "cannot be opened (" + SystemReason() + ")");
  struct stat status {};
  if (fstat(descriptor_, &status) != 0 || !S_ISREG(status.st_mode)) {
    close(descriptor_);
    throw LogError(path_, "not a file");
  }
  NoteInputFile(path_);
  size_ = status.st_size;
  posix_fadvise(descriptor_, 0, 0, POSIX_FADV_SEQUENTIAL);
}

InputFile::~InputFile() { close(descriptor_); }

void InputFile::Read(int64_t offset, std::span<uint8_t> bytes) const {
  while (!bytes.empty()) {
    const ssize_t count = pread(descriptor_, bytes.data(), bytes.size(), offset);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) throw LogError(path_, "cannot be read (" + SystemReason() + ")");
    if (count == 0) throw LogError(path_, "became shorter while it was read");
    bytes = bytes.subspan(static_cast<size_t>(count));
    offset += count;
  }
}

int64_t FileWindow::Clip(int64_t offset, int64_t count) const {
  return std::clamp<int64_t>(file_.size() - offset, 0, count);
}

bool FileWindow::Holds(int64_t offset, int64_t count) const {
  return offset >= start_ && offset + Clip(offset, count) <= start_ + filled_;
}

std::span<const uint8_t> FileWindow::View(int64_t offset, int64_t count) {
  count = Clip(offset, count);
  if (!Holds(offset, count)) {
    const int64_t wanted = Clip(offset, std::max(count, chunk_bytes_));
    const int64_t kept =
        offset >= start_ ? std::max<int64_t>(start_ + filled_ - offset, 0) : int64_t{0};
    if (buffer_.size() < static_cast<size_t>(wanted)) buffer_.resize(static_cast<size_t>(wanted));
    if (kept > 0) {
      std::memmove(buffer_.data(), &buffer_[static_cast<size_t>(offset - start_)],
                   static_cast<size_t>(kept));
    }
    start_ = offset;
    filled_ = kept;
    file_.Read(offset + kept, std::span(buffer_).subspan(static_cast<size_t>(kept),
                                                         static_cast<size_t>(wanted - kept)));
    filled_ = wanted;
  }
  return std::span<const uint8_t>(buffer_).subspan(static_cast<size_t>(offset - start_),
                                                   static_cast<size_t>(count));
}

}  // namespace sprout
