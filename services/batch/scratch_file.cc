#include "services/batch/scratch_file.h"

#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <system_error>

#include "common/logfile/log_error.h"

namespace sprout::batch {

ScratchFile::ScratchFile() {
  const std::filesystem::path folder = std::filesystem::temp_directory_path();
  std::string name = folder / "sprout-batch-XXXXXX";
  descriptor_ = mkstemp(name.data());  // stays open in programs that this one starts
  if (descriptor_ < 0) throw LogError(folder, std::generic_category().message(errno));
  unlink(name.c_str());
}

ScratchFile::~ScratchFile() { close(descriptor_); }

}  // namespace sprout::batch
