#include "common/core/read_text.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <string_view>
#include <system_error>
#include <utility>

namespace sprout {
namespace {

tl::unexpected<Error> CannotRead(const std::string& reason) {
  return Fail("cannot be read (" + reason + ")");
}

tl::unexpected<Error> CannotReadForErrno() {
  return CannotRead(std::generic_category().message(errno));
}

// Reads until the end of the file, whatever size it claims: files of /proc claim 0.
Result<std::string> ReadToEnd(int descriptor, size_t max_bytes) {
  constexpr size_t kChunkBytes = size_t{1} << 16;
  std::string text;
  for (size_t filled = 0;;) {
    text.resize(std::min(filled + kChunkBytes, max_bytes + 1));
    const ssize_t count = read(descriptor, text.data() + filled, text.size() - filled);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return CannotReadForErrno();
    filled += static_cast<size_t>(count);
    if (filled > max_bytes) {
      return CannotRead("larger than " + std::to_string(max_bytes >> 20) + " MiB");
    }
    if (count == 0) {
      text.resize(filled);
      return text;
    }
  }
}

// Windows' editors begin a text with a byte order mark.
Result<std::string> WithoutMark(Result<std::string> text) {
  constexpr std::string_view kUtf8 = "\xef\xbb\xbf";
  if (text && text->starts_with(kUtf8)) text->erase(0, kUtf8.size());
  if (text && (text->starts_with("\xff\xfe") || text->starts_with("\xfe\xff"))) {
    return CannotRead("text in UTF-16; save it as UTF-8");
  }
  if (text && text->starts_with("\x1f\x8b")) {
    return CannotRead("packed with gzip; unpack it with gunzip, an archive with tar -xzf");
  }
  return text;
}

}  // namespace

Result<std::string> ReadText(const std::filesystem::path& path, size_t max_bytes) {
  // A FIFO without a writer would be waited for.
  const int descriptor = open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
  if (descriptor < 0) return CannotReadForErrno();
  struct stat status {};
  Result<std::string> text = fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode)
                                 ? ReadToEnd(descriptor, max_bytes)
                                 : CannotRead("no regular file");
  close(descriptor);
  return WithoutMark(std::move(text));
}

std::string WhyClosed(const std::filesystem::path& path) {
  if (access(path.c_str(), R_OK) == 0 || errno == ENOENT || errno == ENOTDIR) return "";
  return " (" + std::generic_category().message(errno) + ")";
}

}  // namespace sprout
