#pragma once

#include <iosfwd>
#include <map>
#include <opencv2/core/types.hpp>
#include <span>
#include <string>
#include <vector>

#include "common/core/frame.h"

namespace sprout::check {

/// Rules for a program that replaces a stage or capture, in the order in which they are printed.
/// Their texts are in contract.cc.
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

/// The rules that are checked for a stage.
inline constexpr Rule kStageRules[] = {
    Rule::kStart,      Rule::kOneAnswer,  Rule::kHeader,      Rule::kForm,     Rule::kValues,
    Rule::kRepeatable, Rule::kDegenerate, Rule::kBadMessages, Rule::kChannels, Rule::kEnd,
};

/// Inputs and outputs of a stage.
struct StageContract {
  std::string stage;  ///< "refine", "prior", "grow", "temporal", or "pipeline": the first three
  std::vector<Part> inputs;  ///< everything upstream of it, in the graph's order
  Part answer;               ///< one for each frame
  PartSet may_publish;       ///< besides
  bool has_memory = false;   ///< a frame's answer depends on the frames before it
};

/// @throws ConfigError for an unknown stage.
StageContract ContractOf(const std::string& stage);

/// Checks an answer to a complete frame, beyond the checks of convert.h.
///
/// @param pair   that the frame is of.
/// @param what   names the answer in findings.
/// @param found  gets findings of Rule::kForm or kValues.
void CheckAnswer(const PartValue& answer, const RectifiedPair& pair, const std::string& what,
                 Findings& found);

/// Checks what a stage published besides its answer, beyond the checks of convert.h: the size of
/// maps and images, the values of maps and of the confidence. Parameters as CheckAnswer() has them.
void CheckExtra(Part part, const PartValue& extra, const RectifiedPair& pair,
                const std::string& what, Findings& found);

/// Whether an answer is empty: no seed, or no pixel with a disparity.
bool IsEmptyAnswer(const PartValue& answer);

/// Whether two answers are equal.
bool IsSameAnswer(const PartValue& a, const PartValue& b);

/// Whether there are several answers, and all are equal.
bool AreAllTheSame(std::span<const PartValue> answers);

/// One line for people: how far answers are from the recorded ones.
std::string CompareAnswers(std::span<const PartValue> answers, std::span<const PartValue> recorded);

}  // namespace sprout::check
