#include "common/core/input_files.h"

#include <map>
#include <mutex>
#include <set>
#include <system_error>
#include <utility>

namespace sprout {
namespace {

namespace fs = std::filesystem;

struct InputFiles {
  std::mutex mutex;
  bool guarded = false;
  std::set<fs::path> paths;
  std::map<fs::path, std::string> outputs;  // and the flag that asks for each
};

InputFiles& Inputs() {
  static InputFiles inputs;
  return inputs;
}

}  // namespace

InputFileGuard::InputFileGuard() {
  InputFiles& inputs = Inputs();
  const std::lock_guard lock(inputs.mutex);
  inputs.guarded = true;
}

InputFileGuard::~InputFileGuard() {
  InputFiles& inputs = Inputs();
  const std::lock_guard lock(inputs.mutex);
  inputs.guarded = false;
  inputs.paths.clear();
  inputs.outputs.clear();
}

void NoteInputFile(const fs::path& path) {
  InputFiles& inputs = Inputs();
  const std::lock_guard lock(inputs.mutex);
  std::error_code error;
  if (!inputs.guarded || !fs::is_regular_file(path, error)) return;
  fs::path whole = fs::canonical(path, error);
  if (!error) inputs.paths.insert(std::move(whole));
}

std::string NoteOutputFile(const std::string& flag, const fs::path& path) {
  InputFiles& inputs = Inputs();
  const std::lock_guard lock(inputs.mutex);
  std::error_code error;
  // What is there and no regular file, such as /dev/stdout, takes both.
  if (!inputs.guarded || (fs::exists(path, error) && !fs::is_regular_file(path, error))) return "";
  const fs::path whole = fs::weakly_canonical(fs::absolute(path, error), error);
  return inputs.outputs.emplace(whole, flag).first->second;
}

bool IsInputFile(const fs::path& path) {
  InputFiles& inputs = Inputs();
  const std::lock_guard lock(inputs.mutex);
  std::error_code error;
  const fs::path whole = fs::canonical(path, error);
  return !error && inputs.paths.contains(whole);
}

}  // namespace sprout
