#ifndef SPROUT_SERVICES_CHECK_CONTRACT_H_
#define SPROUT_SERVICES_CHECK_CONTRACT_H_

#include <opencv2/core/types.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/core/frame.h"
#include "services/check/findings.h"

namespace sprout::check {

/// What is looked at in a stage.
inline constexpr Rule kStageRules[] = {
    Rule::kStart,      Rule::kOneAnswer,  Rule::kHeader,      Rule::kForm,     Rule::kValues,
    Rule::kRepeatable, Rule::kDegenerate, Rule::kBadMessages, Rule::kChannels, Rule::kEnd,
};

/// What goes into a stage and what comes out of it.
struct StageContract {
  std::string stage;         ///< "refine", "prior", "grow", or "pipeline": all three
  std::vector<Part> inputs;  ///< all that the graph has upstream of it, in the graph's order
  Part answer;               ///< one for each frame
  PartSet may_publish;       ///< besides
};

/// @throws ConfigError for an unknown stage.
StageContract ContractOf(const std::string& stage);

/// What holds for any answer to a whole frame, besides what the border guard (convert.h) refuses.
///
/// @param size   of the rectified images, px.
/// @param what   names the answer in what is found.
/// @param found  gets what is wrong: Rule::kForm or kValues.
void CheckAnswer(const PartValue& answer, cv::Size size, const std::string& what, Findings& found);

/// Whether an answer says nothing: no seed, or no pixel with a disparity.
bool IsEmptyAnswer(const PartValue& answer);

/// Whether two answers say the same.
bool IsSameAnswer(const PartValue& a, const PartValue& b);

/// One line for people on how far answers are from those that were recorded.
std::string CompareAnswers(std::span<const PartValue> answers, std::span<const PartValue> recorded);

}  // namespace sprout::check

#endif  // SPROUT_SERVICES_CHECK_CONTRACT_H_
