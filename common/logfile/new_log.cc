#include "common/logfile/new_log.h"

#include <system_error>
#include <utility>

namespace sprout {
namespace {

namespace fs = std::filesystem;

fs::path PartPath(const fs::path& path, bool overwrite) {
  std::error_code ignored;
  if (fs::is_directory(path, ignored)) throw LogError(path, "cannot be written (a folder)");
  if (!overwrite && fs::exists(path, ignored)) {
    throw LogError(path, "exists already; --force overwrites it");
  }
  fs::path part = path;
  part += ".part";
  return part;
}

}  // namespace

NewLog::NewLog(fs::path path, bool overwrite)
    : path_(std::move(path)), part_path_(PartPath(path_, overwrite)), writer_(part_path_) {}

NewLog::~NewLog() {
  std::error_code ignored;
  if (!committed_) fs::remove(part_path_, ignored);
}

void NewLog::Commit() {
  writer_.Close();
  std::error_code error;
  fs::rename(part_path_, path_, error);
  if (error) throw LogError(path_, "cannot be written (" + error.message() + ")");
  committed_ = true;
}

}  // namespace sprout
