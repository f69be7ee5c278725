#include "services/batch/scratch_file.h"

#include <sys/sendfile.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <system_error>

#include "common/logfile/log_error.h"

namespace sprout {

ScratchFile::ScratchFile() {
  const std::filesystem::path folder = std::filesystem::temp_directory_path();
  std::string name = folder / "sprout-batch-XXXXXX";
  descriptor_ = mkstemp(name.data());  // stays open in programs that this one starts
  if (descriptor_ < 0) throw LogError(folder, std::generic_category().message(errno));
  unlink(name.c_str());
}

void ScratchFile::Append(const InputFile& from, int64_t offset, int64_t bytes) {
  while (bytes > 0) {
    const ssize_t count =
        sendfile(descriptor_, from.descriptor(), &offset, static_cast<size_t>(bytes));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) {
      throw LogError(path(), "cannot be written (" + std::generic_category().message(errno) + ")");
    }
    if (count == 0) throw LogError(from.path(), "became shorter while it was read");
    bytes -= count;
  }
}

ScratchFile::~ScratchFile() { close(descriptor_); }

}  // namespace sprout
