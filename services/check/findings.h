#ifndef SPROUT_SERVICES_CHECK_FINDINGS_H_
#define SPROUT_SERVICES_CHECK_FINDINGS_H_

#include <iosfwd>
#include <map>
#include <span>
#include <string>

namespace sprout::check {

/// What a program must keep to stand in for a stage or for capture, in the order in which it is
/// printed. Its words are in findings.cc.
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

/// What is wrong with a program, by rule.
class Findings {
 public:
  /// The first of a rule is printed, the others are counted.
  void Add(Rule rule, const std::string& text);

  /// A rule that was looked at; of the others nothing is known.
  void Checked(Rule rule) { found_[rule]; }

  bool empty() const;

  /// One line for each of `rules`: "ok", "WRONG" with what was found first, or "not checked".
  void Print(std::span<const Rule> rules, std::ostream& out) const;

 private:
  struct Found {
    std::string first;
    int count = 0;
  };

  std::map<Rule, Found> found_;
};

}  // namespace sprout::check

#endif  // SPROUT_SERVICES_CHECK_FINDINGS_H_
