#include "common/core/output_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <bit>
#include <cerrno>
#include <optional>
#include <system_error>
#include <utility>

#include "common/core/input_files.h"
#include "common/core/number_text.h"

namespace sprout {
namespace {

namespace fs = std::filesystem;

static_assert(std::endian::native == std::endian::little, "WriteNumber() writes memory as it is");

constexpr size_t kBufferBytes = size_t{1} << 20;
constexpr int kMaxParts = 100;  // of one name: others are at work, or were killed

/// The open descriptor that a path stands for.
std::optional<int> DescriptorOf(const fs::path& path) {
  if (path == "/dev/stdout") return STDOUT_FILENO;
  if (path == "/dev/stderr") return STDERR_FILENO;
  if (path.parent_path() != "/dev/fd") return std::nullopt;
  return ParseNumber<int>(path.filename().native());
}

/// The path by which a file without a name gets one.
std::string LinkTo(int descriptor) { return "/proc/self/fd/" + std::to_string(descriptor); }

/// Kind of what has a name, 0 when nothing has.
mode_t KindOf(const fs::path& path) {
  struct stat status {};
  return lstat(path.c_str(), &status) == 0 ? status.st_mode & S_IFMT : 0;
}

/// Why no file may take the place of something of this kind; empty: it may.
std::string ObstacleOf(mode_t kind) {
  const std::string allowed = "; allowed: a new name, a regular file, /dev/stdout or /dev/null";
  switch (kind) {
    case 0:
    case S_IFREG:
      return "";
    case S_IFDIR:
      return "a folder" + allowed;
    case S_IFLNK:
      return "a symbolic link" + allowed;
    case S_IFIFO:
      return "a FIFO" + allowed;
    case S_IFBLK:
      return "a disk" + allowed;
    default:
      return "no regular file" + allowed;
  }
}

}  // namespace

std::string OutputFile::Obstacle() const {
  if (over_input_ == OverInput::kRefused && IsInputFile(path_)) {
    return "it is an input of this run; allowed: another file";
  }
  return ObstacleOf(KindOf(path_));
}

OutputFile::OutputFile(fs::path path, OverInput over_input)
    : path_(std::move(path)), over_input_(over_input) {
  buffer_.reserve(kBufferBytes);
  const mode_t kind = KindOf(path_);
  if (path_.filename().empty()) {
    failure_ = "it names no file";
  } else if (const auto open_already = DescriptorOf(path_)) {
    // Shares its position with the original, so that nothing that was written there is lost.
    descriptor_ = fcntl(*open_already, F_DUPFD_CLOEXEC, 0);
    if (descriptor_ < 0) FailWithErrno();
  } else if (kind == S_IFCHR) {
    descriptor_ = open(path_.c_str(), O_WRONLY | O_CLOEXEC | O_NOCTTY);
    if (descriptor_ < 0) FailWithErrno();
  } else {
    replaces_ = kind == S_IFREG;
    failure_ = Obstacle();
    if (failure_.empty()) OpenPart();
  }
}

// @param make  makes a file of a name that there is not, and says whether it could.
template <typename Make>
void OutputFile::MakePart(const Make& make) {
  for (int i = 1; i <= kMaxParts; ++i) {
    fs::path part = path_;
    part += i == 1 ? ".part" : ".part" + std::to_string(i);
    if (make(part)) {
      part_path_ = std::move(part);
      return;
    }
    if (errno != EEXIST) break;
  }
  FailWithErrno();
}

void OutputFile::OpenPart() {
  const fs::path folder = path_.has_parent_path() ? path_.parent_path() : ".";
  descriptor_ = open(folder.c_str(), O_TMPFILE | O_WRONLY | O_CLOEXEC, 0666);
  is_nameless_ = descriptor_ >= 0 && access(LinkTo(descriptor_).c_str(), F_OK) == 0;
  if (is_nameless_) return;
  if (descriptor_ >= 0) close(descriptor_);  // without /proc it would get no name
  MakePart([this](const fs::path& part) {
    descriptor_ = open(part.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    return descriptor_ >= 0;
  });
}

OutputFile::~OutputFile() {
  if (descriptor_ >= 0) close(descriptor_);
  RemovePart();
}

void OutputFile::RemovePart() {
  if (!part_path_.empty()) unlink(part_path_.c_str());
  part_path_.clear();
}

void OutputFile::FailWithErrno() {
  if (failure_.empty()) failure_ = std::generic_category().message(errno);
}

void OutputFile::Write(std::string_view bytes) {
  if (buffer_.size() + bytes.size() > kBufferBytes) Flush();
  if (bytes.size() > kBufferBytes) {
    WriteOut(bytes);
  } else if (failure_.empty()) {
    buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
  }
}

void OutputFile::WriteOut(std::string_view bytes) {
  while (failure_.empty() && !bytes.empty()) {
    const ssize_t written = write(descriptor_, bytes.data(), bytes.size());
    if (written >= 0) {
      bytes.remove_prefix(static_cast<size_t>(written));
    } else if (errno != EINTR) {
      FailWithErrno();
    }
  }
}

void OutputFile::Flush() {
  WriteOut({buffer_.data(), buffer_.size()});
  buffer_.clear();
}

Result<void> OutputFile::Commit() {
  Flush();
  if (failure_.empty() && is_nameless_) {
    MakePart([this](const fs::path& part) {
      return linkat(AT_FDCWD, LinkTo(descriptor_).c_str(), AT_FDCWD, part.c_str(),
                    AT_SYMLINK_FOLLOW) == 0;
    });
  }
  if (descriptor_ >= 0 && close(std::exchange(descriptor_, -1)) != 0) FailWithErrno();
  if (failure_.empty() && !part_path_.empty()) {
    failure_ = Obstacle();  // it may have come meanwhile
    if (failure_.empty() && std::rename(part_path_.c_str(), path_.c_str()) != 0) FailWithErrno();
    if (failure_.empty()) part_path_.clear();
  }
  if (failure_.empty()) return {};
  RemovePart();
  return Fail("cannot write " + path_.string() + ": " + failure_);
}

}  // namespace sprout
