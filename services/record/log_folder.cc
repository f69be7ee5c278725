#include "services/record/log_folder.h"

#include <fcntl.h>
#include <fmt/chrono.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <ctime>
#include <span>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include "common/config/config_error.h"
#include "common/core/number_text.h"
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

namespace fs = std::filesystem;

constexpr std::string_view kNameBegin = "record_";
constexpr std::string_view kNameEnd = ".lcm";

/// Bytes of all files in a folder and below it. What cannot be read below it, as when it is deleted
/// meanwhile, does not count.
int64_t BytesIn(const fs::path& folder, bool is_below = false) {
  int64_t bytes = 0;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    std::error_code gone;
    const fs::file_status status = entry->symlink_status(gone);
    if (fs::is_directory(status)) bytes += BytesIn(entry->path(), /*is_below=*/true);
    const auto size = fs::is_regular_file(status) ? entry->file_size(gone) : 0;
    if (!gone) bytes += static_cast<int64_t>(size);
  }
  if (error && !is_below) throw LogError(folder, "cannot be read (" + error.message() + ")");
  return bytes;
}

// Files with larger numbers are ignored: counting on from them could overflow.
constexpr int64_t kMaxNumber = 1'000'000'000'000'000;

struct OwnLog {
  int64_t number;
  fs::path path;
  auto operator<=>(const OwnLog&) const = default;
};

std::vector<OwnLog> OwnLogs(const fs::path& folder) {
  std::vector<OwnLog> logs;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    if (const auto number = RecordingNumber(entry->path()))
      logs.push_back({*number, entry->path()});
  }
  if (error) throw LogError(folder, "cannot be read (" + error.message() + ")");
  std::ranges::sort(logs);
  return logs;
}

ConfigError Unusable(const fs::path& folder, const std::string& reason) {
  return ConfigError("--dir " + folder.string() + ": " + reason +
                     "; allowed: a folder of its own that can be written to");
}

int Lock(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  const int descriptor = error ? -1 : open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  // Checked at the start, while the user is still looking, not at the first message.
  if (descriptor < 0 || faccessat(descriptor, ".", W_OK | X_OK, AT_EACCESS) != 0) {
    if (!error) error = std::error_code(errno, std::generic_category());
    if (descriptor >= 0) close(descriptor);
    throw Unusable(folder, "cannot be used (" + error.message() + ")");
  }
  // Some network file systems have no locks, so other errors are ignored.
  if (flock(descriptor, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
    close(descriptor);
    throw Unusable(folder, "another process records there");
  }
  return descriptor;
}

std::string MbText(int64_t bytes) {
  return fmt::format("{:.1f} MB", static_cast<double>(bytes) / 1e6);
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
    // If this fails, too, the log ends inside an event, which Sprout's readers skip.
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

std::optional<int64_t> RecordingNumber(const fs::path& path) {
  const std::string name = path.filename();
  if (!name.starts_with(kNameBegin) || !name.ends_with(kNameEnd)) return std::nullopt;
  const std::string_view rest = std::string_view(name).substr(kNameBegin.size());
  if (rest.starts_with('-') || rest.find('_') == std::string_view::npos) return std::nullopt;
  return ParseNumber<int64_t>(rest.substr(0, rest.find('_')));
}

LogFolder::LogFolder(LogFolderOptions options, LastEvent last_event)
    : options_(std::move(options)),
      last_event_(std::move(last_event)),
      lock_(Lock(options_.folder)) {
  for (const OwnLog& log : OwnLogs(options_.folder)) {
    if (log.number < kMaxNumber) next_number_ = log.number + 1;
  }
  held_bytes_ = BytesIn(options_.folder);
}

LogFolder::~LogFolder() { close(lock_); }

void LogFolder::Write(const RecordedEvent& event) {
  const int64_t bytes = RecordingFile::BytesOf(event);
  if (file_ && file_->events() > 0 && file_->bytes() + bytes > options_.max_file_bytes) Close();
  if (!file_) held_bytes_ = BytesIn(options_.folder);
  MakeRoom(bytes);
  if (!file_) Open(event.utime);
  Append(event);
}

void LogFolder::Append(const RecordedEvent& event) {
  file_->Write(event);
  const int64_t bytes = RecordingFile::BytesOf(event);
  held_bytes_ += bytes;
  bytes_ += bytes;
  ++events_;
}

void LogFolder::Open(int64_t utime) {
  const auto seconds = static_cast<std::time_t>(utime / 1'000'000);
  file_ = std::make_unique<RecordingFile>(
      options_.folder / fmt::format("{}{:06}_{:%Y%m%d_%H%M%S}Z{}", kNameBegin, next_number_,
                                    fmt::gmtime(seconds), kNameEnd));
  ++next_number_;
  ++files_;
}

void LogFolder::Close() {
  if (!file_) return;
  std::string failure;
  try {
    Append(last_event_());
  } catch (const LogError& error) {
    failure = error.what();
  }
  const std::unique_ptr<RecordingFile> file = std::move(file_);
  file->Close();
  if (!failure.empty()) throw LogError(file->path(), "has no last status: " + failure);
}

// The last event may exceed the quota, by less than 2 kB.
void LogFolder::MakeRoom(int64_t bytes) {
  if (held_bytes_ + bytes <= options_.quota_bytes) return;
  held_bytes_ = BytesIn(options_.folder);  // somebody may have made room
  while (held_bytes_ + bytes > options_.quota_bytes) {
    if (options_.delete_oldest && DeleteOldest()) continue;
    throw LogError(options_.folder,
                   fmt::format("holds {}, and its quota is {}{}", MbText(held_bytes_),
                               MbText(options_.quota_bytes),
                               options_.delete_oldest ? "; no older recording is left to delete"
                                                      : "; nothing was deleted"));
  }
}

bool LogFolder::DeleteOldest() {
  for (const OwnLog& log : OwnLogs(options_.folder)) {
    if (file_ && log.path == file_->path()) continue;
    std::error_code error;
    const auto size = fs::file_size(log.path, error);
    if (error || !fs::remove(log.path, error)) continue;
    held_bytes_ -= static_cast<int64_t>(size);
    ++deleted_;
    return true;
  }
  return false;
}

void LogFolder::RequireThere() const {
  std::error_code error;
  if (!fs::is_directory(options_.folder, error)) throw LogError(options_.folder, "has vanished");
  if (file_ && !file_->IsThere()) throw LogError(file_->path(), "has vanished");
}

}  // namespace sprout::record
