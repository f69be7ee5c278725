#ifndef SPROUT_SERVICES_TOOLS_BATCH_LOG_TRY_H_
#define SPROUT_SERVICES_TOOLS_BATCH_LOG_TRY_H_

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>

#include "services/tools/batch/manifest.h"

namespace sprout::batch {

/// One try to compute a log, which has a file failed/LOG.TRY.txt while it runs. The file is removed
/// when the try succeeds, and gets the reason when it fails. If the process is killed, or its
/// machine dies, the file stays, so such tries are counted, too.
class LogTry {
 public:
  /// @param log  its number in the manifest; below, too.
  LogTry(const BatchFolder& folder, int log);
  ~LogTry();
  LogTry(const LogTry&) = delete;
  LogTry& operator=(const LogTry&) = delete;

  /// Keeps the file, with this text. Only the first reason is kept.
  void Fail(const std::string& why);

 private:
  std::filesystem::path path_;
  bool failed_ = false;
};

/// Number of tries that did not succeed, by log; logs without such a try are left out. Running
/// tries are included. O(tries).
std::map<int, int> FailedTries(const BatchFolder& folder);

/// File of the last of them. @pre `tries` > 0, as FailedTries() says.
std::filesystem::path TryPath(const BatchFolder& folder, int log, int tries);

/// Does not count the last try of a log, which was ended by Ctrl-C.
void ForgetTry(const BatchFolder& folder, int log);

}  // namespace sprout::batch

#endif  // SPROUT_SERVICES_TOOLS_BATCH_LOG_TRY_H_
