#include "common/app/output_paths.h"

#include <stdexcept>
#include <system_error>

#include "common/config/config_error.h"
#include "common/core/input_files.h"
#include "common/core/output_file.h"

namespace sprout {
namespace {

namespace fs = std::filesystem;

ConfigError NotWritable(const std::string& flag, const fs::path& path, const std::string& reason) {
  return ConfigError(flag + " " + path.string() + ": cannot be written (" + reason + ")");
}

}  // namespace

void RequireWritableFile(const std::string& flag, const fs::path& path) {
  const OutputFile probe(path);
  if (!probe.failure().empty()) throw NotWritable(flag, path, probe.failure());
  const std::string first = NoteOutputFile(flag, path);
  if (first.empty() || first == flag) return;
  throw NotWritable(flag, path, first + " writes it; allowed: another file");
}

void RequireWritableFolder(const std::string& flag, const fs::path& folder,
                           std::initializer_list<const char*> names) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw NotWritable(flag, folder, error.message());
  for (const char* name : names) RequireWritableFile(flag, folder / name);
}

void WriteWhole(const fs::path& path, std::string_view text) {
  OutputFile file(path);
  file.Write(text);
  if (const Result<void> written = file.Commit(); !written) {
    throw std::runtime_error(written.error().text);
  }
}

}  // namespace sprout
