#ifndef SPROUT_SERVICES_BATCH_SHARD_TRY_H_
#define SPROUT_SERVICES_BATCH_SHARD_TRY_H_

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>

#include "services/batch/manifest.h"

namespace sprout::batch {

/// One try to compute a shard, which has a file failed/SHARD.TRY.txt while it runs. The file is
/// removed when the try succeeds, and gets the reason when it fails. If the process is killed, or
/// its machine dies, the file stays, so such tries are counted, too.
class ShardTry {
 public:
  ShardTry(const BatchFolder& folder, size_t shard);
  ~ShardTry();
  ShardTry(const ShardTry&) = delete;
  ShardTry& operator=(const ShardTry&) = delete;

  /// Keeps the file, with this text. Only the first reason is kept.
  void Fail(const std::string& why);

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
  bool failed_ = false;
};

/// Number of tries that did not succeed, by shard; shards without such a try are left out. Running
/// tries are included. O(tries).
std::map<size_t, int64_t> FailedTries(const BatchFolder& folder);

/// File of the last of them. @pre `tries` > 0, as FailedTries() says.
std::filesystem::path TryPath(const BatchFolder& folder, size_t shard, int64_t tries);

/// Does not count the last try of a shard, which was ended by Ctrl-C.
void ForgetTry(const BatchFolder& folder, size_t shard);

}  // namespace sprout::batch

#endif  // SPROUT_SERVICES_BATCH_SHARD_TRY_H_
