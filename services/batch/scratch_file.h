#ifndef SPROUT_SERVICES_BATCH_SCRATCH_FILE_H_
#define SPROUT_SERVICES_BATCH_SCRATCH_FILE_H_

#include <string>

namespace sprout::batch {

/// A file without a name in the folder for temporary files ($TMPDIR, /tmp). It vanishes when the
/// last program that has it open ends, in any way, so nothing is left behind. Programs that this
/// one starts can read and write it by its path.
class ScratchFile {
 public:
  /// @throws LogError when there is no space for it.
  ScratchFile();
  ~ScratchFile();
  ScratchFile(const ScratchFile&) = delete;
  ScratchFile& operator=(const ScratchFile&) = delete;

  /// "/dev/fd/7": OutputFile writes to it directly, LogReader reads it from its beginning.
  std::string path() const { return "/dev/fd/" + std::to_string(descriptor_); }

 private:
  int descriptor_;
};

}  // namespace sprout::batch

#endif  // SPROUT_SERVICES_BATCH_SCRATCH_FILE_H_
