#include "common/logfile/log_writer.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <limits>
#include <string>
#include <system_error>
#include <utility>

#include "common/logfile/event_format.h"

namespace sprout {
namespace {

constexpr size_t kBufferBytes = size_t{1} << 20;

std::string SystemReason() { return std::generic_category().message(errno); }

// Emptied only when nobody else uses it.
int OpenForWriting(const std::filesystem::path& path) {
  const int descriptor = open(path.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0666);
  if (descriptor < 0) throw LogError(path, "cannot be written (" + SystemReason() + ")");
  struct stat status {};
  std::string reason;
  if (flock(descriptor, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
    reason = "cannot be written (it is in use, perhaps as the log to read)";
  } else if (fstat(descriptor, &status) != 0 ||
             (S_ISREG(status.st_mode) && ftruncate(descriptor, 0) != 0)) {
    reason = "cannot be written (" + SystemReason() + ")";
  }
  if (reason.empty()) return descriptor;
  close(descriptor);
  throw LogError(path, reason);
}

}  // namespace

LogWriter::LogWriter(const std::filesystem::path& path) : path_(path) {
  const int descriptor = OpenForWriting(path);
  file_ = fdopen(descriptor, "wb");
  if (file_ == nullptr) {
    const std::string reason = SystemReason();
    close(descriptor);
    throw LogError(path, "cannot be written (" + reason + ")");
  }
  std::setvbuf(file_, nullptr, _IOFBF, kBufferBytes);
}

LogWriter::~LogWriter() {
  if (file_ != nullptr) std::fclose(file_);
}

void LogWriter::Write(int64_t utime, std::string_view channel, std::span<const uint8_t> data) {
  if (channel.empty() || channel.size() > kMaxChannelBytes) {
    throw LogError(path_, "channel '" + std::string(channel) + "': allowed are 1 to 63 characters");
  }
  if (data.size() > static_cast<size_t>(std::numeric_limits<int32_t>::max())) {
    throw LogError(path_, "a message of " + std::to_string(data.size()) +
                              " bytes: allowed are less than 2^31");
  }
  const auto header = EncodeHeader({.number = events_,
                                    .utime = utime,
                                    .channel_bytes = static_cast<int32_t>(channel.size()),
                                    .data_bytes = static_cast<int32_t>(data.size())});
  Put(header.data(), header.size());
  Put(channel.data(), channel.size());
  Put(data.data(), data.size());
  ++events_;
}

void LogWriter::Put(const void* bytes, size_t count) {
  if (count == 0) return;  // `bytes` may be null then
  if (std::fwrite(bytes, 1, count, file_) != count) {
    throw LogError(path_, "cannot be written (" + SystemReason() + ")");
  }
}

void LogWriter::Close() {
  if (file_ == nullptr) return;
  if (std::fclose(std::exchange(file_, nullptr)) != 0) {
    throw LogError(path_, "cannot be written (" + SystemReason() + ")");
  }
}

}  // namespace sprout
