#ifndef SPROUT_COMMON_ROS_UNPACKED_FILE_H_
#define SPROUT_COMMON_ROS_UNPACKED_FILE_H_

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

namespace sprout {

/// What a file that was packed with zstd holds.
struct UnpackedFile {
  std::ifstream file;
  uint64_t size = 0;
  std::string complaint;  ///< why it is not whole; empty: it is
};

/// Unpacks a file that is packed as a whole (rosbag2's --compression-mode file) into a temporary
/// one, in TMPDIR, which has no name any more when this returns. From a torn file all that is there
/// is unpacked.
/// @param magic  what its content must begin with; else nothing is unpacked.
/// @throws McapError when it begins otherwise, or there is no room for it.
UnpackedFile UnpackFile(const std::filesystem::path& path, std::string_view magic);

}  // namespace sprout

#endif  // SPROUT_COMMON_ROS_UNPACKED_FILE_H_
