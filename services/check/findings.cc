#include "services/check/findings.h"

#include <algorithm>
#include <ostream>

namespace sprout {
namespace {

constexpr std::pair<Rule, const char*> kRuleTexts[] = {
    {Rule::kStart, "starts and answers"},        {Rule::kOneAnswer, "one answer a frame"},
    {Rule::kHeader, "header passed on"},         {Rule::kForm, "type, size and encoding"},
    {Rule::kValues, "values in range"},          {Rule::kRepeatable, "same frame, same answer"},
    {Rule::kDegenerate, "poor frames answered"}, {Rule::kBadMessages, "bad messages survived"},
    {Rule::kChannels, "keeps to its channels"},  {Rule::kEnd, "ends on SIGTERM"},
};

}  // namespace

void Findings::Add(Rule rule, const std::string& text) {
  Found& found = found_[rule];
  if (found.count++ == 0) found.first = text;
}

bool Findings::empty() const {
  return std::all_of(found_.begin(), found_.end(),
                     [](const auto& entry) { return entry.second.count == 0; });
}

void Findings::Print(std::ostream& out) const {
  for (const auto& [rule, text] : kRuleTexts) {
    const auto found = found_.find(rule);
    if (found == found_.end()) {
      out << "-      " << text << ": not checked\n";
    } else if (found->second.count == 0) {
      out << "ok     " << text << "\n";
    } else {
      out << "WRONG  " << text << ": " << found->second.first;
      if (found->second.count > 1) out << " (and " << found->second.count - 1 << " more)";
      out << "\n";
    }
  }
}

}  // namespace sprout
