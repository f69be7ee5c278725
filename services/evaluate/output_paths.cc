#include "services/evaluate/output_paths.h"

#include <system_error>

#include "common/config/config_error.h"
#include "common/core/output_file.h"

namespace sprout::evaluate {
namespace {

namespace fs = std::filesystem;

ConfigError NotWritable(const std::string& flag, const fs::path& path, const std::string& reason) {
  return ConfigError(flag + " " + path.string() + ": cannot be written (" + reason + ")");
}

}  // namespace

void RequireWritableFile(const std::string& flag, const fs::path& path) {
  const OutputFile probe(path);
  if (!probe.failure().empty()) throw NotWritable(flag, path, probe.failure());
}

void RequireWritableFolder(const std::string& flag, const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw NotWritable(flag, folder, error.message());
  RequireWritableFile(flag, folder / "figure.png");
  RequireWritableFile(flag, folder / "errors.png");
}

}  // namespace sprout::evaluate
