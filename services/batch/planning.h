#ifndef SPROUT_SERVICES_BATCH_PLANNING_H_
#define SPROUT_SERVICES_BATCH_PLANNING_H_

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "services/batch/manifest.h"

namespace sprout::batch {

/// The options of a run.
struct BatchRequest {
  std::vector<std::string> inputs;  ///< logs, folders of logs (*.lcm), @LIST files
  std::string out;
  std::vector<std::string> stages = {"refine", "prior", "grow"};
  std::vector<std::string> keep;      ///< empty: the last stage
  std::vector<std::string> config_a;  ///< as --config of the services
  std::vector<std::string> config_b;  ///< empty: that of A, if there is a B
  std::string programs_a;             ///< folder of the programs
  std::string programs_b;             ///< empty: that of A, if there is a B
  std::string truth;
  bool measured = true;  ///< see BatchHead
  std::string prefix;
  int64_t shard_megabytes = 192;
};

/// The selected logs: absolute paths, without duplicates, in order.
struct FoundLogs {
  std::vector<std::string> logs;
  /// Those whose paths are not allowed in a manifest, as text for people (Printable()).
  std::vector<std::string> left_out;
};

/// Folders are searched for *.lcm, also below. @throws ConfigError for missing inputs, a list that
/// contains itself, and when no log is left.
FoundLogs FindLogs(const std::vector<std::string>& inputs);

/// One line on stderr for each log that is left out.
void SayLeftOut(const std::vector<std::string>& left_out);

/// Indexes the logs that have no index, several at a time. Says on stderr which ones were damaged.
/// @param fallback  folder for indexes that cannot be kept beside their logs; empty: none.
/// @returns how many indexes are in `fallback`. @throws ConfigError, Interrupted.
int64_t IndexLogs(const std::vector<std::string>& logs, const std::filesystem::path& fallback);

/// The manifest of a request, written to its folder with the effective configurations. An existing
/// manifest with the same settings and logs is kept.
/// @param program  path of sprout-batch.
/// @throws ConfigError, LogError.
Manifest Plan(const BatchRequest& request, const std::string& program);

}  // namespace sprout::batch

#endif  // SPROUT_SERVICES_BATCH_PLANNING_H_
