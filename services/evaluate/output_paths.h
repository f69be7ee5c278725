#ifndef SPROUT_SERVICES_EVALUATE_OUTPUT_PATHS_H_
#define SPROUT_SERVICES_EVALUATE_OUTPUT_PATHS_H_

#include <filesystem>
#include <string>

namespace sprout::evaluate {

// Checked before a long run, so that writing its results does not fail.

/// Checks that a file can be written; leaves nothing behind and an older file as it is.
/// @throws ConfigError naming flag, path and the system's reason.
void RequireWritableFile(const std::string& flag, const std::filesystem::path& path);

/// Creates a folder (and those above it) unless it is there, and checks that files can be written
/// to it.
/// @throws ConfigError naming flag, path and the system's reason.
void RequireWritableFolder(const std::string& flag, const std::filesystem::path& folder);

}  // namespace sprout::evaluate

#endif  // SPROUT_SERVICES_EVALUATE_OUTPUT_PATHS_H_
