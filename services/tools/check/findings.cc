#include "services/tools/check/findings.h"

#include <algorithm>
#include <ostream>
#include <string_view>

namespace sprout::check {
namespace {

std::string_view TextOf(Rule rule) {
  switch (rule) {
    case Rule::kStart:
      return "starts and answers";
    case Rule::kSends:
      return "starts and sends frames";
    case Rule::kOneAnswer:
      return "one answer a frame";
    case Rule::kHeader:
      return "header passed on";
    case Rule::kWhole:
      return "LEFT, RIGHT and TOF of every frame, once";
    case Rule::kSameHeader:
      return "one header on all three";
    case Rule::kRising:
      return "utime rises, seq by one";
    case Rule::kCalibration:
      return "RIG before the frames, and again";
    case Rule::kForm:
      return "type, size and encoding";
    case Rule::kValues:
      return "values in range";
    case Rule::kRepeatable:
      return "same frame, same answer";
    case Rule::kDegenerate:
      return "poor frames answered";
    case Rule::kBadMessages:
      return "bad messages survived";
    case Rule::kChannels:
      return "keeps to its channels";
    case Rule::kEnd:
      return "ends on SIGTERM";
  }
  return "";
}

}  // namespace

void Findings::Add(Rule rule, const std::string& text) {
  Found& found = found_[rule];
  if (found.count++ == 0) found.first = text;
}

bool Findings::empty() const {
  return std::all_of(found_.begin(), found_.end(),
                     [](const auto& entry) { return entry.second.count == 0; });
}

void Findings::Print(std::span<const Rule> rules, std::ostream& out) const {
  for (const Rule rule : rules) {
    const std::string_view text = TextOf(rule);
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

}  // namespace sprout::check
