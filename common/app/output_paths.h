#pragma once

#include <filesystem>
#include <initializer_list>
#include <string>
#include <string_view>

namespace sprout {

// Checked before a long run, so that writing its results does not fail.

/// Checks that a file can be written, and that no other flag of this run asked to write it; leaves
/// nothing behind and an older file as it is.
/// @throws ConfigError naming flag, path and the system's reason.
void RequireWritableFile(const std::string& flag, const std::filesystem::path& path);

/// Creates a folder (and those above it) unless it is there, and checks that files of these names
/// can be written to it.
/// @throws ConfigError naming flag, path and the system's reason.
void RequireWritableFolder(const std::string& flag, const std::filesystem::path& folder,
                           std::initializer_list<const char*> names);

/// Writes a whole file or none. @throws std::runtime_error naming path and reason.
void WriteWhole(const std::filesystem::path& path, std::string_view text);

}  // namespace sprout
