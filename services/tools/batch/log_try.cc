#include "services/tools/batch/log_try.h"

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

LogTry::LogTry(const BatchFolder& folder, int log) {
  std::error_code ignored;
  std::filesystem::create_directories(folder.failures(), ignored);
  int descriptor = -1;
  for (int i = 1; descriptor < 0; ++i) {
    path_ = TryPath(folder, log, i);
    descriptor = open(path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (descriptor < 0 && errno != EEXIST) return;  // what cannot be written shows at the results
  }
  close(descriptor);
  std::ofstream(path_) << fmt::format(
      "started on {} by process {}; if that is not running any more, it was killed\n", HostName(),
      getpid());
}

LogTry::~LogTry() {
  std::error_code ignored;
  if (!failed_) std::filesystem::remove(path_, ignored);
}

void LogTry::Fail(const std::string& why) {
  if (std::exchange(failed_, true)) return;
  std::ofstream(path_) << why << "\n";
}

std::filesystem::path TryPath(const BatchFolder& folder, int log, int tries) {
  return folder.failures() / fmt::format("{}.{}.txt", log, tries);
}

std::map<int, int> FailedTries(const BatchFolder& folder) {
  std::map<int, int> tries;
  std::error_code none;
  for (const auto& file : std::filesystem::directory_iterator(folder.failures(), none)) {
    const std::string name = file.path().filename();
    const size_t dot = name.find('.');
    if (dot == std::string::npos) continue;
    const auto log = ParseNumber<int>(std::string_view(name).substr(0, dot));
    if (log) ++tries[*log];
  }
  return tries;
}

void ForgetTry(const BatchFolder& folder, int log) {
  const auto tries = FailedTries(folder);
  const auto found = tries.find(log);
  if (found != tries.end()) {
    std::filesystem::remove(TryPath(folder, log, found->second));
  }
}

}  // namespace sprout::batch
