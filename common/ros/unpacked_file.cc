#include "common/ros/unpacked_file.h"

#include <unistd.h>
#include <zstd.h>

#include <algorithm>
#include <memory>
#include <vector>

#include "common/ros/mcap_file.h"

namespace sprout {
namespace {

namespace fs = std::filesystem;

struct StreamDeleter {
  void operator()(ZSTD_DCtx* context) const { ZSTD_freeDCtx(context); }
};

// A file in TMPDIR that goes away with this object; whoever has it open keeps its content.
class TemporaryFile {
 public:
  TemporaryFile() : path_((fs::temp_directory_path() / "sprout-XXXXXX").string()) {
    const int descriptor = mkstemp(path_.data());
    if (descriptor >= 0) close(descriptor);
  }
  ~TemporaryFile() {
    std::error_code ignored;
    fs::remove(path_, ignored);
  }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

}  // namespace

UnpackedFile UnpackFile(const fs::path& path, std::string_view magic) {
  const TemporaryFile temporary;
  std::ofstream to(temporary.path(), std::ios::binary);
  std::ifstream from(path, std::ios::binary);
  const std::unique_ptr<ZSTD_DCtx, StreamDeleter> context(ZSTD_createDCtx());
  std::vector<char> packed(ZSTD_DStreamInSize());
  std::vector<char> block(ZSTD_DStreamOutSize());
  UnpackedFile unpacked;
  size_t result = 0;  // 0 at the end of a frame
  while (unpacked.complaint.empty() && from.read(packed.data(), std::ssize(packed)).gcount() > 0) {
    ZSTD_inBuffer in{packed.data(), static_cast<size_t>(from.gcount()), 0};
    for (bool is_full = true; in.pos < in.size || is_full;) {
      ZSTD_outBuffer out{block.data(), block.size(), 0};
      result = ZSTD_decompressStream(context.get(), &out, &in);
      if (ZSTD_isError(result) != 0) {
        unpacked.complaint =
            std::string("cannot be unpacked further: ") + ZSTD_getErrorName(result);
        break;
      }
      is_full = out.pos == out.size;
      if (unpacked.size == 0 && out.pos > 0 &&
          !std::string_view(block.data(), out.pos).starts_with(magic)) {
        throw McapError(path.string() + ": no MCAP file in it");
      }
      to.write(block.data(), static_cast<std::streamsize>(out.pos));
      unpacked.size += out.pos;
    }
    if (!to) throw McapError(path.string() + ": no room to unpack it in " + temporary.path());
  }
  if (unpacked.size == 0) throw McapError(path.string() + ": no MCAP file in it");
  if (unpacked.complaint.empty() && result != 0) {
    unpacked.complaint = "the packed file ends before its content does";
  }
  to.close();
  unpacked.file.open(temporary.path(), std::ios::binary);
  if (!to || !unpacked.file) {
    throw McapError(path.string() + ": no room to unpack it in " + temporary.path());
  }
  return unpacked;
}

}  // namespace sprout
