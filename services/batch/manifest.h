#ifndef SPROUT_SERVICES_BATCH_MANIFEST_H_
#define SPROUT_SERVICES_BATCH_MANIFEST_H_

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "services/batch/log_index.h"
#include "services/batch/shard_plan.h"

namespace sprout::batch {

/// A program that a stage is run with.
struct StageProgram {
  std::string path;
  std::string digest;   ///< of its bytes
  std::string version;  ///< as it prints it, for people

  bool operator==(const StageProgram&) const = default;
};

/// A variant: programs with a configuration. Two of them are compared.
struct Variant {
  std::string name;           ///< "a" or "b"
  std::string config_digest;  ///< of the effective configuration, which is in config_NAME.textproto
  std::map<std::string, StageProgram> programs;  ///< by stage

  bool operator==(const Variant&) const = default;
};

/// A log of the batch.
struct BatchLog {
  std::string path;   ///< absolute
  std::string name;   ///< of its results, see IsResultName(); no two logs have the same
  std::string index;  ///< path of its index
  IndexSummary summary;
  int64_t incomplete = 0;  ///< frames that miss a message
  int64_t left_out = 0;    ///< frame numbers missing in the first stage's messages
};

/// All settings that decide the results, besides the logs: equal heads give equal results.
struct BatchHead {
  StageNames stages;
  StageNames keep;          ///< stages whose answers are results; the last stage is one of them
  std::string prefix;       ///< of the channels
  int64_t shard_bytes = 0;  ///< approximate size of a shard
  bool measured = true;     ///< whether the quality of each frame is measured for the table
  std::string truth;        ///< folder of true disparities; empty: none
  std::string tables;       ///< digest of sprout-batch, which computes the tables
  std::vector<std::string> left_out;  ///< logs that were asked for, but whose names cannot be used
  std::vector<Variant> variants;      ///< one or two

  bool operator==(const BatchHead&) const = default;
};

/// The description of a batch: written once, read by each of its processes. One line of JSON for
/// the head, one for each log, one for each shard.
struct Manifest {
  BatchHead head;
  std::vector<BatchLog> logs;
  std::vector<Shard> shards;  ///< in the order of the logs, and of their frames

  /// Shards of a log.
  std::vector<size_t> ShardsOf(size_t log) const;
};

/// Paths of the files of a batch.
class BatchFolder {
 public:
  explicit BatchFolder(std::filesystem::path root) : root_(std::move(root)) {}

  const std::filesystem::path& root() const { return root_; }
  std::filesystem::path manifest() const { return root_ / "manifest.jsonl"; }
  std::filesystem::path config(const std::string& variant) const {
    return root_ / ("config_" + variant + ".textproto");
  }
  std::filesystem::path indexes() const { return root_ / "indexes"; }
  std::filesystem::path failures() const { return root_ / "failed"; }
  std::filesystem::path table() const { return root_ / "frames.csv"; }
  std::filesystem::path report() const { return root_ / "report.html"; }
  std::filesystem::path merged(const BatchLog& log, const std::string& variant) const {
    return root_ / "logs" / (log.name + "_" + variant + ".lcm");
  }

  /// Folder of the answers of a shard with a variant, by its key.
  std::filesystem::path result(const std::string& key) const;

  /// Folder with the table of differences in a shard between the variants, or from the truth, by
  /// its key.
  std::filesystem::path comparison(const std::string& key) const;

 private:
  std::filesystem::path root_;
};

/// The name of a result: digest of input, stages, programs and configuration. Equal keys have equal
/// results, also from other batches.
std::string ResultKey(const BatchHead& head, const Variant& variant, const Shard& shard);

/// The name of a comparison.
std::string ComparisonKey(const BatchHead& head, const BatchLog& log, const Shard& shard);

/// Whether there is something to compare: disparity maps of two variants, or of one with a truth.
bool Compares(const BatchHead& head);

/// @throws LogError when it cannot be written.
void WriteManifest(const std::filesystem::path& path, const Manifest& manifest);

/// Checks every field, since a manifest is untrusted.
/// @throws ConfigError when there is none, or it is damaged or of another version: one line that
///         names field, value and what is allowed.
Manifest ReadManifest(const std::filesystem::path& path);

/// Reads one shard with its log, without keeping the others. @throws ConfigError as above, also for
/// a number without a shard.
struct ShardOfBatch {
  BatchHead head;
  BatchLog log;
  Shard shard;
};
ShardOfBatch ReadShard(const std::filesystem::path& path, size_t number);

}  // namespace sprout::batch

#endif  // SPROUT_SERVICES_BATCH_MANIFEST_H_
