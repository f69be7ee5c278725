#ifndef SPROUT_SERVICES_TOOLS_CHECK_CONTRACT_H_
#define SPROUT_SERVICES_TOOLS_CHECK_CONTRACT_H_

#include <opencv2/core/types.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/core/frame.h"
#include "services/tools/check/findings.h"

namespace sprout::check {

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
/// @param size   of the rectified images, px.
/// @param what   names the answer in findings.
/// @param found  gets findings of Rule::kForm or kValues.
void CheckAnswer(const PartValue& answer, cv::Size size, const std::string& what, Findings& found);

/// Whether an answer is empty: no seed, or no pixel with a disparity.
bool IsEmptyAnswer(const PartValue& answer);

/// Whether two answers are equal.
bool IsSameAnswer(const PartValue& a, const PartValue& b);

/// One line for people: how far answers are from the recorded ones.
std::string CompareAnswers(std::span<const PartValue> answers, std::span<const PartValue> recorded);

}  // namespace sprout::check

#endif  // SPROUT_SERVICES_TOOLS_CHECK_CONTRACT_H_
