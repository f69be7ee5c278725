#ifndef SPROUT_COMMON_CORE_READ_TEXT_H_
#define SPROUT_COMMON_CORE_READ_TEXT_H_

#include <cstddef>
#include <filesystem>
#include <string>

#include "common/core/result.h"

namespace sprout {

/// What a configuration, a rig or a calibration may have; none that people write comes near.
constexpr size_t kMaxTextBytes = size_t{1} << 20;
/// What a list of files or a table that a program wrote may have.
constexpr size_t kMaxListBytes = size_t{1} << 26;

/// Reads a small text file.
///
/// @returns its bytes; or why it cannot be read, without the path: missing, no regular file (but a
///          folder, a FIFO, a device), larger than that, or an error of the disk. Never waits for a
///          writer, and never holds more than max_bytes.
Result<std::string> ReadText(const std::filesystem::path& path, size_t max_bytes = kMaxTextBytes);

}  // namespace sprout

#endif  // SPROUT_COMMON_CORE_READ_TEXT_H_
