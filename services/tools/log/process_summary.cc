#include "services/tools/log/process_summary.h"

#include <fmt/core.h>

#include <algorithm>
#include <set>

#include "common/config/config_difference.h"
#include "common/messages/codec.h"

namespace sprout::log {

void ProcessSummary::Add(std::span<const uint8_t> bytes) {
  Result<ProcessInfo> info = DecodeProcessInfo(bytes);
  if (!info || processes_.size() == kMost) return;
  if (std::ranges::find(processes_, *info) != processes_.end()) return;
  processes_.push_back(*std::move(info));
}

const ProcessInfo* ProcessSummary::NewestOf(const std::string& stage) const {
  const auto found = std::find_if(processes_.rbegin(), processes_.rend(),
                                  [&](const ProcessInfo& info) { return info.stage == stage; });
  return found == processes_.rend() ? nullptr : &*found;
}

std::string ConfigDiffText(const ProcessSummary& a, const ProcessSummary& b) {
  std::set<std::string> stages;
  for (const ProcessInfo& info : a.processes()) stages.insert(info.stage);
  std::string text;
  for (const std::string& stage : stages) {
    const ProcessInfo& in_a = *a.NewestOf(stage);
    const ProcessInfo* const in_b = b.NewestOf(stage);
    if (in_b == nullptr) continue;
    if (in_a.version != in_b->version) {
      text += fmt::format("{}: version {} in A, {} in B\n", stage, in_a.version, in_b->version);
    }
    for (const auto& [key, value_a, value_b] :
         ConfigDifferences(in_a.config_text, in_b->config_text)) {
      text += fmt::format("{}: {} = {} in A, {} in B\n", stage, key, value_a, value_b);
    }
  }
  return text;
}

}  // namespace sprout::log
