#include "services/view/shared_files.h"

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

}  // namespace sprout::view
