#include "services/tools/check/contract.h"

#include <fmt/core.h>

#include <algorithm>
#include <ostream>
#include <string_view>
#include <utility>

#include "common/config/config_error.h"
#include "common/core/answer_values.h"
#include "common/core/disparity_diff.h"
#include "common/core/image.h"

namespace sprout::check {
namespace {

constexpr std::pair<Rule, std::string_view> kTexts[] = {
    {Rule::kStart, "starts and answers"},
    {Rule::kSends, "starts and sends frames"},
    {Rule::kOneAnswer, "one answer a frame"},
    {Rule::kHeader, "header passed on"},
    {Rule::kWhole, "LEFT, RIGHT and TOF of every frame, once"},
    {Rule::kSameHeader, "one header on all three"},
    {Rule::kRising, "utime rises, seq by one"},
    {Rule::kCalibration, "RIG before the frames, and again"},
    {Rule::kForm, "type, size and encoding"},
    {Rule::kValues, "values in range"},
    {Rule::kRepeatable, "same frame, same answer"},
    {Rule::kDegenerate, "poor frames answered"},
    {Rule::kBadMessages, "bad messages survived"},
    {Rule::kChannels, "keeps to its channels"},
    {Rule::kEnd, "ends on SIGTERM"},
};
static_assert(std::size(kTexts) == static_cast<size_t>(Rule::kEnd) + 1, "a text for each rule");

void CheckSeeds(const SeedSet& set, const RectifiedPair& pair, const std::string& what,
                Findings& found) {
  if (const auto wrong = WrongSeed(set.seeds, pair.size(), LeastDisparity(pair))) {
    return found.Add(Rule::kValues, what + ": " + *wrong);
  }
  if (const int32_t from_tof = CountTofSeeds(set.seeds); set.raw < from_tof) {
    found.Add(Rule::kValues,
              fmt::format("{}: raw_count = {} with {} ToF seeds; allowed is at least their number",
                          what, set.raw, from_tof));
  }
}

void CheckMap(const DisparityImage& map, const RectifiedPair& pair, const std::string& what,
              Findings& found) {
  if (map.size() != pair.size()) {
    found.Add(Rule::kForm, fmt::format("{}: a map of {}; allowed is the size of LEFT, {}", what,
                                       SizeText(map.size()), SizeText(pair.size())));
    return;
  }
  if (const auto wrong = WrongDisparity(map, LeastDisparity(pair))) {
    found.Add(Rule::kValues, what + ": " + *wrong);
  }
}

// A confidence of 0 to 1, as of a probability.
bool IsShare(const cv::Mat& confidence) {
  double largest = 0;
  cv::minMaxLoc(confidence, nullptr, &largest);
  return largest == 1;
}

// The map in an answer of prior or grow.
const DisparityImage& MapOf(const PartValue& answer) {
  const auto* prior = std::get_if<PriorMap>(&answer);
  return prior != nullptr ? prior->disparity : std::get<DisparityImage>(answer);
}

bool IsSameMat(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && cv::countNonZero(a != b) == 0;
}

std::string CompareMaps(std::span<const PartValue> answers, std::span<const PartValue> recorded) {
  int64_t pixels = 0;
  int64_t valid = 0;
  int64_t compared = 0;
  double sum = 0;
  for (size_t i = 0; i < answers.size(); ++i) {
    const auto& map = MapOf(answers[i]);
    const auto& other = MapOf(recorded[i]);
    if (map.size() != other.size()) continue;
    const DisparityDiff diff = Compare(map, other);
    const int64_t valid_here = map.CountValid();
    pixels += diff.pixels;
    valid += valid_here;
    compared += valid_here - diff.newly_invalid;
    sum += diff.sum_px;
  }
  if (pixels == 0 || compared == 0) return "nothing to compare with the recorded answers";
  return fmt::format(
      "{:.1f} % of the pixels have a disparity; {:.3f} px from the recorded ones in the mean",
      100.0 * static_cast<double>(valid) / static_cast<double>(pixels),
      sum / static_cast<double>(compared));
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
    const std::string_view text =
        std::ranges::find(kTexts, rule, &std::pair<Rule, std::string_view>::first)->second;
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

StageContract ContractOf(const std::string& stage) {
  // In the graph's order; a stage takes everything upstream of it.
  constexpr Part kGraph[] = {Part::kRig,   Part::kLeft,      Part::kRight,
                             Part::kTof,   Part::kSeeds,     Part::kLeftSeeds,
                             Part::kPrior, Part::kDisparity, Part::kConfidence};
  const auto contract = [&](size_t inputs, Part answer, PartSet may_publish) {
    return StageContract{.stage = stage,
                         .inputs = {kGraph, kGraph + inputs},
                         .answer = answer,
                         .may_publish = may_publish,
                         .has_memory = answer == Part::kFused};
  };
  if (stage == "refine") return contract(4, Part::kSeeds, {Part::kLeftSeeds});
  if (stage == "prior") return contract(6, Part::kPrior, {});
  if (stage == "grow") {
    return contract(7, Part::kDisparity, {Part::kUnfilled, Part::kConfidence, Part::kSigma});
  }
  if (stage == "temporal") {
    return contract(9, Part::kFused, {Part::kFusedConfidence, Part::kMotion});
  }
  if (stage == "pipeline") {
    return contract(
        4, Part::kDisparity,
        {Part::kSeeds, Part::kLeftSeeds, Part::kPrior, Part::kUnfilled, Part::kConfidence,
         Part::kSigma, Part::kFused, Part::kFusedConfidence, Part::kMotion});
  }
  throw ConfigError("STAGE '" + stage +
                    "': allowed are capture, refine, prior, grow, temporal and pipeline");
}

void CheckAnswer(const PartValue& answer, const RectifiedPair& pair, const std::string& what,
                 Findings& found) {
  if (const auto* seeds = std::get_if<SeedSet>(&answer)) {
    CheckSeeds(*seeds, pair, what, found);
  } else {
    CheckMap(MapOf(answer), pair, what, found);
  }
}

void CheckExtra(Part part, const PartValue& extra, const RectifiedPair& pair,
                const std::string& what, Findings& found) {
  if (const auto* image = std::get_if<cv::Mat>(&extra)) {
    if (image->size() == pair.size() && image->channels() == 1) {
      if (part == Part::kConfidence && IsShare(*image)) {
        found.Add(Rule::kValues,
                  what + ": 0 and 1 alone; allowed is 255 times the probability, 0 to 255");
      }
      return;
    }
    found.Add(Rule::kForm,
              fmt::format("{}: an image of {} with {} bytes a pixel; allowed is the size of LEFT, "
                          "{}, in grey",
                          what, SizeText(image->size()), image->channels(), SizeText(pair.size())));
  } else if (std::holds_alternative<PriorMap>(extra) ||
             std::holds_alternative<DisparityImage>(extra)) {
    CheckMap(MapOf(extra), pair, what, found);
  }
}

bool IsEmptyAnswer(const PartValue& answer) {
  if (const auto* seeds = std::get_if<SeedSet>(&answer)) return seeds->seeds.empty();
  return MapOf(answer).CountValid() == 0;
}

bool IsSameAnswer(const PartValue& a, const PartValue& b) {
  if (const auto* seeds = std::get_if<SeedSet>(&a)) return *seeds == std::get<SeedSet>(b);
  if (!IsSameMat(MapOf(a).counts(), MapOf(b).counts())) return false;
  const auto* prior = std::get_if<PriorMap>(&a);
  return prior == nullptr || IsSameMat(prior->sigma, std::get<PriorMap>(b).sigma);
}

bool AreAllTheSame(std::span<const PartValue> answers) {
  return answers.size() > 1 && std::ranges::all_of(answers, [&](const PartValue& answer) {
           return IsSameAnswer(answer, answers[0]);
         });
}

std::string CompareAnswers(std::span<const PartValue> answers,
                           std::span<const PartValue> recorded) {
  if (answers.empty() || answers.size() != recorded.size()) {
    return "nothing to compare with the recorded answers";
  }
  if (!std::holds_alternative<SeedSet>(answers[0])) return CompareMaps(answers, recorded);
  size_t seeds = 0;
  size_t recorded_seeds = 0;
  for (const PartValue& value : answers) seeds += std::get<SeedSet>(value).seeds.size();
  for (const PartValue& value : recorded) recorded_seeds += std::get<SeedSet>(value).seeds.size();
  return fmt::format("{} seeds in all; the recorded answers have {}", seeds, recorded_seeds);
}

}  // namespace sprout::check
