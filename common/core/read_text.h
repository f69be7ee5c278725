#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

#include "common/core/result.h"

namespace sprout {

/// Largest configuration, rig or calibration, bytes; far more than people write.
constexpr size_t kMaxTextBytes = size_t{1} << 20;
/// Largest list of files or table written by a program, bytes.
constexpr size_t kMaxListBytes = size_t{1} << 26;

/// Reads a small text file.
///
/// @returns its bytes, without a byte order mark of UTF-8 in front; or why it cannot be read,
/// without the path: missing, not a regular file (a
///          folder, a FIFO, a device), too large, UTF-16, or an error of the disk. Never waits for
///          a writer, and never allocates more than max_bytes.
Result<std::string> ReadText(const std::filesystem::path& path, size_t max_bytes = kMaxTextBytes);

/// Why a file or folder cannot be read that may well be there, to stand behind what a program did
/// not find: " (Permission denied)"; empty where nothing is there, or it can be read.
std::string WhyClosed(const std::filesystem::path& path);

}  // namespace sprout
