#ifndef SPROUT_SERVICES_LOG_PROCESS_SUMMARY_H_
#define SPROUT_SERVICES_LOG_PROCESS_SUMMARY_H_

#include <span>
#include <string>
#include <vector>

#include "common/core/process_info.h"

namespace sprout::log {

/// The processes that a log tells of (SPROUT_PROCESS), each once although it says so every few
/// seconds.
class ProcessSummary {
 public:
  /// Takes a message; what is undecodable or repeated leaves everything as it is.
  void Add(std::span<const uint8_t> bytes);

  /// In the order in which they came; at most kMost.
  const std::vector<ProcessInfo>& processes() const { return processes_; }

  /// The newest process of a stage; null when there is none.
  const ProcessInfo* NewestOf(const std::string& stage) const;

  static constexpr size_t kMost = 100;

 private:
  std::vector<ProcessInfo> processes_;
};

/// A line for each key that the newest processes of a stage in two logs do not have in common, and
/// for versions that differ; empty when all is the same.
std::string ConfigDiffText(const ProcessSummary& a, const ProcessSummary& b);

}  // namespace sprout::log

#endif  // SPROUT_SERVICES_LOG_PROCESS_SUMMARY_H_
