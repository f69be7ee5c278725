#include "services/view/shared_files.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>
#include <utility>

namespace sprout::view {

Result<SharedFiles::File> SharedFiles::Take(const std::string& name, Clock::time_point now,
                                            const Write& write) {
  const std::lock_guard lock(mutex_);
  std::erase_if(entries_, [](const Entry& entry) { return entry.file.expired(); });
  long readers = 0;
  for (const Entry& entry : entries_) readers += entry.file.use_count();
  if (readers >= kMaxReaders) return File();
  for (const Entry& entry : entries_) {
    if (entry.name != name || now - entry.written > kFresh) continue;
    if (File file = entry.file.lock()) return file;
  }
  if (entries_.size() >= max_files_) return File();
  auto file = std::make_shared<const MemoryFile>();
  if (auto written = write(file->path()); !written) return tl::unexpected(written.error());
  entries_.push_back({name, now, file});
  return file;
}

MemoryFile::MemoryFile() : descriptor_(memfd_create("sprout-view", MFD_CLOEXEC)) {
  if (descriptor_ < 0) throw std::system_error(errno, std::generic_category(), "memory file");
}

MemoryFile::~MemoryFile() {
  if (descriptor_ >= 0) close(descriptor_);
}

MemoryFile::MemoryFile(MemoryFile&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)) {}

std::filesystem::path MemoryFile::path() const { return "/dev/fd/" + std::to_string(descriptor_); }

int MemoryFile::OpenForReading() const {
  const std::string name = "/proc/self/fd/" + std::to_string(descriptor_);
  const int descriptor = open(name.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) throw std::system_error(errno, std::generic_category(), name);
  return descriptor;
}

}  // namespace sprout::view
