#include "services/batch/shard_try.h"

#include <fcntl.h>
#include <fmt/core.h>
#include <unistd.h>

#include <cerrno>
#include <fstream>
#include <system_error>
#include <utility>

#include "common/core/host_name.h"
#include "common/core/number_text.h"

namespace sprout::batch {

namespace fs = std::filesystem;

ShardTry::ShardTry(const BatchFolder& folder, size_t shard) {
  std::error_code ignored;
  fs::create_directories(folder.failures(), ignored);
  int descriptor = -1;
  for (int64_t i = 1; descriptor < 0; ++i) {
    path_ = TryPath(folder, shard, i);
    descriptor = open(path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (descriptor < 0 && errno != EEXIST) return;  // what cannot be written shows at the results
  }
  close(descriptor);
  std::ofstream(path_) << fmt::format(
      "started on {} by process {}; if that is not running any more, it was killed\n", HostName(),
      getpid());
}

ShardTry::~ShardTry() {
  std::error_code ignored;
  if (!failed_) fs::remove(path_, ignored);
}

void ShardTry::Fail(const std::string& why) {
  if (std::exchange(failed_, true)) return;
  std::ofstream(path_) << why << "\n";
}

fs::path TryPath(const BatchFolder& folder, size_t shard, int64_t tries) {
  return folder.failures() / fmt::format("{}.{}.txt", shard, tries);
}

std::map<size_t, int64_t> FailedTries(const BatchFolder& folder) {
  std::map<size_t, int64_t> tries;
  std::error_code none;
  for (const auto& file : fs::directory_iterator(folder.failures(), none)) {
    const std::string name = file.path().filename();
    const size_t dot = name.find('.');
    if (dot == std::string::npos) continue;
    const auto shard = ParseNumber<size_t>(std::string_view(name).substr(0, dot));
    if (shard) ++tries[*shard];
  }
  return tries;
}

void ForgetTry(const BatchFolder& folder, size_t shard) {
  const auto tries = FailedTries(folder);
  const auto found = tries.find(shard);
  if (found != tries.end()) fs::remove(TryPath(folder, shard, found->second));
}

}  // namespace sprout::batch
