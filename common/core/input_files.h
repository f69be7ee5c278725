#pragma once

#include <filesystem>
#include <string>

namespace sprout {

// The files that a program reads, of which none may be replaced by what it writes: readers of files
// note what they open, and OutputFile refuses those. There is one list for the whole process, since
// readers and writers know nothing of each other. Paths are compared without links and "..".
// Thread-safe.

/// While it lives files are noted, and then forgotten. Every program of ours has one (RunProgram).
/// In other people's programs nothing is noted: they may replace what they have read.
class InputFileGuard {
 public:
  InputFileGuard();
  ~InputFileGuard();
  InputFileGuard(const InputFileGuard&) = delete;
  InputFileGuard& operator=(const InputFileGuard&) = delete;
};

/// Notes a file that is read, or will be. What is no regular file is not noted.
void NoteInputFile(const std::filesystem::path& path);

/// Notes a file that a flag asks to write.
/// @returns the first flag that asked for it; empty: the file takes what several write, or none is
///          noted.
std::string NoteOutputFile(const std::string& flag, const std::filesystem::path& path);

/// Whether a file was noted as read.
bool IsInputFile(const std::filesystem::path& path);

}  // namespace sprout
