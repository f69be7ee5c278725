#ifndef SPROUT_SERVICES_TOOLS_LOG_PROCESS_SUMMARY_H_
#define SPROUT_SERVICES_TOOLS_LOG_PROCESS_SUMMARY_H_

#include <span>
#include <string>
#include <vector>

#include "common/core/process_info.h"

namespace sprout::log {

/// The processes in a log (SPROUT_PROCESS), each listed once although it sends the message every
/// few seconds.
class ProcessSummary {
 public:
  /// Takes a message; undecodable and repeated ones are ignored.
  void Add(std::span<const uint8_t> bytes);

  /// The processes in the order in which they came; at most kMost.
  const std::vector<ProcessInfo>& processes() const { return processes_; }

  /// The newest process of a stage; null when there is none.
  const ProcessInfo* NewestOf(const std::string& stage) const;

  static constexpr size_t kMost = 100;

 private:
  std::vector<ProcessInfo> processes_;
};

/// A line for each key that differs between the newest processes of a stage in two logs, and for
/// different versions; empty when all are equal.
std::string ConfigDiffText(const ProcessSummary& a, const ProcessSummary& b);

}  // namespace sprout::log

#endif  // SPROUT_SERVICES_TOOLS_LOG_PROCESS_SUMMARY_H_
