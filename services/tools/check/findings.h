#ifndef SPROUT_SERVICES_TOOLS_CHECK_FINDINGS_H_
#define SPROUT_SERVICES_TOOLS_CHECK_FINDINGS_H_

#include <iosfwd>
#include <map>
#include <span>
#include <string>

namespace sprout::check {

/// Rules for a program that replaces a stage or capture, in the order in which they are printed.
/// Their texts are in findings.cc.
enum class Rule {
  kStart,
  kSends,
  kOneAnswer,
  kHeader,
  kWhole,
  kSameHeader,
  kRising,
  kCalibration,
  kForm,
  kValues,
  kRepeatable,
  kDegenerate,
  kBadMessages,
  kChannels,
  kEnd,
};

/// Findings about a program, by rule.
class Findings {
 public:
  /// The first of a rule is printed, the others are counted.
  void Add(Rule rule, const std::string& text);

  /// Marks a rule as checked; other rules are unknown.
  void Checked(Rule rule) { found_[rule]; }

  bool empty() const;

  /// One line for each of `rules`: "ok", "WRONG" with the first finding, or "not checked".
  void Print(std::span<const Rule> rules, std::ostream& out) const;

 private:
  struct Found {
    std::string first;
    int count = 0;
  };

  std::map<Rule, Found> found_;
};

}  // namespace sprout::check

#endif  // SPROUT_SERVICES_TOOLS_CHECK_FINDINGS_H_
