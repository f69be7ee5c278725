#include "services/evaluate/output_paths.h"

#include <cerrno>
#include <cstdio>
#include <system_error>

#include "common/config/config.h"

namespace sprout {
namespace {

namespace fs = std::filesystem;

ConfigError NotWritable(const std::string& flag, const fs::path& path, const std::string& reason) {
  return ConfigError(flag + " " + path.string() + ": cannot be written (" + reason +
                     "); allowed: a path in a folder that is there and writable");
}

}  // namespace

void RequireWritableFile(const std::string& flag, const fs::path& path) {
  std::error_code ignored;
  if (path.filename().empty() || fs::is_directory(path, ignored)) {
    throw NotWritable(flag, path, "a folder");
  }
  fs::path probe = path;
  probe += ".part";  // the name under which the file will grow
  std::FILE* const file = std::fopen(probe.c_str(), "wb");
  if (file == nullptr) throw NotWritable(flag, path, std::generic_category().message(errno));
  std::fclose(file);
  fs::remove(probe, ignored);
}

void RequireWritableFolder(const std::string& flag, const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw NotWritable(flag, folder, error.message());
  RequireWritableFile(flag, folder / "figure.png");
  RequireWritableFile(flag, folder / "errors.png");
}

}  // namespace sprout
