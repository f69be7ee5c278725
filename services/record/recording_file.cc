#include "services/record/recording_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <span>
#include <system_error>
#include <utility>

#include "common/logfile/event_format.h"

namespace sprout::record {
namespace {

/// 0, or the errno of what went wrong.
int WriteAll(int descriptor, std::span<const uint8_t> bytes) {
  while (!bytes.empty()) {
    const ssize_t written = write(descriptor, bytes.data(), bytes.size());
    if (written >= 0) {
      bytes = bytes.subspan(static_cast<size_t>(written));
    } else if (errno != EINTR) {
      return errno;
    }
  }
  return 0;
}

}  // namespace

RecordingFile::RecordingFile(std::filesystem::path path)
    : path_(std::move(path)),
      descriptor_(open(path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666)) {
  if (descriptor_ < 0) Fail(errno);
}

RecordingFile::~RecordingFile() {
  if (descriptor_ >= 0) close(descriptor_);
}

void RecordingFile::Fail(int error) const {
  throw LogError(path_, "cannot be written (" + std::generic_category().message(error) + ")");
}

int64_t RecordingFile::BytesOf(const RecordedEvent& event) {
  return kHeaderBytes + static_cast<int64_t>(event.channel.size() + event.data.size());
}

void RecordingFile::Write(const RecordedEvent& event) {
  const auto header = EncodeHeader({.number = events_,
                                    .utime = event.utime,
                                    .channel_bytes = static_cast<int32_t>(event.channel.size()),
                                    .data_bytes = static_cast<int32_t>(event.data.size())});
  std::vector<uint8_t> head(header.begin(), header.end());
  head.insert(head.end(), event.channel.begin(), event.channel.end());
  int error = WriteAll(descriptor_, head);
  if (error == 0) error = WriteAll(descriptor_, event.data);
  if (error != 0) {
    // Where even this fails, the log has a torn tail, which every reader of ours passes over.
    if (ftruncate(descriptor_, bytes_) == 0) lseek(descriptor_, bytes_, SEEK_SET);
    Fail(error);
  }
  bytes_ += BytesOf(event);
  ++events_;
}

void RecordingFile::Close() {
  const int unsynced = fdatasync(descriptor_) == 0 ? 0 : errno;
  const int unclosed = close(std::exchange(descriptor_, -1)) == 0 ? 0 : errno;
  if (unsynced != 0) Fail(unsynced);
  if (unclosed != 0) Fail(unclosed);
}

bool RecordingFile::IsThere() const {
  struct stat own {};
  struct stat found {};
  return fstat(descriptor_, &own) == 0 && stat(path_.c_str(), &found) == 0 &&
         own.st_dev == found.st_dev && own.st_ino == found.st_ino;
}

}  // namespace sprout::record
