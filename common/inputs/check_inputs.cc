#include "common/inputs/check_inputs.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include "common/core/image.h"
#include "common/inputs/judges.h"

namespace sprout::inputs {
namespace {

Findings NoneCanTell(const std::string& why) {
  Findings findings;
  for (int i = 0; i < kQuestionCount; ++i) {
    findings.push_back({.question = static_cast<Question>(i), .text = why});
  }
  return findings;
}

// How many times as far from the corner the principal point lies as the middle of the images, if
// that is far in both directions alike, as in images that were resized, or outside of them in both;
// else 1. Where cy is the middle to the last digit nobody has said it: then cx alone counts, from
// farther on, as images may be cropped.
// @param camera  a RectifiedPair or a TofCamera.
template <typename Camera>
double TimesMiddle(const Camera& camera) {
  constexpr double kResized = 1.3;
  constexpr double kFarCrop = 1.6;
  constexpr double kAlike = 1.15;
  const double columns = (2 * camera.cx + 1) / camera.width;
  const double down = (2 * camera.cy + 1) / camera.height;
  const double rows = down == 1 ? columns : down;
  const auto is_beyond = [](double ratio, double most) { return ratio > most || ratio < 1 / most; };
  const bool is_outside = columns > 2 && rows > 2;
  if (!(columns > 0 && rows > 0) || (!is_outside && is_beyond(columns / rows, kAlike))) return 1;
  const double times = std::sqrt(columns * rows);
  return is_beyond(times, down == 1 ? kFarCrop : kResized) ? times : 1;
}

// What is unlikely in a calibration, as a baseline of 10 m; empty: nothing.
std::string UnlikelyCalibration(const RectifiedPair& pair) {
  constexpr double kMaxBaselineM = 5;
  constexpr double kMinBaselineM = 1e-3;
  if (pair.baseline_m > kMaxBaselineM) {
    return fmt::format(
        "the cameras are {:.4g} m apart, and no range shows that it is so: is the "
        "calibration in mm or cm? it has to be in m",
        pair.baseline_m);
  }
  if (pair.baseline_m < kMinBaselineM) {
    return fmt::format(
        "the cameras are {:.2g} mm apart, and no range shows that it is so: is the "
        "baseline in m, and P of ROS with −f·b, not −b?",
        1000 * pair.baseline_m);
  }
  if (const double times = TimesMiddle(pair); times != 1) {
    return fmt::format(
        "the principal point ({:.1f}, {:.1f}) lies {:.2g} times as far from the "
        "corner as the middle of images of {}, and no range shows that f is right: is "
        "the calibration of images of another size, about {:.0f}x{:.0f}?",
        pair.cx, pair.cy, times, SizeText(pair.size()), times * pair.width, times * pair.height);
  }
  return {};
}

// Calls the scale bad where no ranges show it and the calibration is unlikely.
void SayUnlikely(const RectifiedPair& pair, Finding& scale) {
  if (scale.verdict != Verdict::kCannotTell) return;
  std::string text = UnlikelyCalibration(pair);
  if (text.empty()) return;
  scale.verdict = Verdict::kBad;
  scale.text = std::move(text);
}

// Says that the range sensor's lens is that of images of another size: then points look turned,
// late or of another scale. Where they fit nevertheless, the range images were cropped.
void SayResizedRanges(const Rig& rig, Findings& findings) {
  const double times = TimesMiddle(rig.tof);
  const auto found = [&](Question question) -> Finding& {
    return *std::ranges::find(findings, question, &Finding::question);
  };
  Finding& place = found(Question::kPlace);
  Finding& scale = found(Question::kScale);
  Finding& moment = found(Question::kMoment);
  const bool all_good = std::ranges::all_of(
      std::array{&place, &scale, &moment},
      [](const Finding* finding) { return finding->verdict == Verdict::kGood; });
  if (times == 1 || all_good || TimesMiddle(rig.pair) != 1) return;
  scale.verdict = Verdict::kBad;
  scale.text = fmt::format(
      "the range sensor's principal point ({:.1f}, {:.1f}) lies {:.2g} times as far from the "
      "corner "
      "as the middle of its images of {}x{}: is its calibration of images of another size, about "
      "{:.0f}x{:.0f}?",
      rig.tof.cx, rig.tof.cy, times, rig.tof.width, rig.tof.height, times * rig.tof.width,
      times * rig.tof.height);
  for (Finding* other : {&place, &moment}) {
    other->verdict = Verdict::kCannotTell;
    other->text = "the range sensor's lens has to be put right first";
  }
}

// Beside a pair that does not fit: what no misfit of it explains, turned range images, units, and
// numbers that are no depths.
void SayGross(const RangeModel& ranges, Finding& finding) {
  constexpr double kSure = 0.8;
  for (Finding& one : JudgeRanges(&ranges, /*pair_fits=*/true)) {
    if (one.question != finding.question || one.verdict != Verdict::kBad) continue;
    const bool is_turned = one.question == Question::kPlace && std::isinf(one.moved_px) &&
                           ranges.turned.share() >= kSure;
    const bool is_misread = one.question == Question::kScale &&
                            ranges.misread.with.reading != Reading::kAlongRay &&
                            ranges.misread.share() >= std::max(kSure, ranges.scaled.share());
    if (is_turned || is_misread || (!one.flag.empty() && ranges.scaled.share() >= kSure)) {
      finding = std::move(one);
    }
  }
}

// Whether the rows of a pair are off alike, which moves no columns, so that its matches tell of
// ranges nevertheless; unless columns that are moved alike, too, may explain these.
bool OnlyRowsAreOff(const PairModel& model, int width, const RangeModel& ranges) {
  constexpr double kEvenRows = 0.5;  // as of ColumnErrorPx()
  constexpr double kAlikePx = 0.5;
  constexpr double kMayExplain = 0.5;
  const Hypothesis& aside = ranges.aside.with;
  const bool are_ranges_aside =
      aside.turn == Turn{} && aside.factor == 1 && ranges.aside.close_share() >= kMayExplain;
  return !are_ranges_aside &&
         ColumnErrorPx(model, width) <= kEvenRows * std::abs(model.middle_px.value) + kAlikePx;
}

struct Shown {
  Matches matches;
  PairModel model;
};

// Matches on the finest of three levels that shows one scene, since noise, and blur of one image,
// hide corners on fine levels; on the finest where none does.
Shown MatchLevels(const cv::Mat1b& left, const cv::Mat1b& right) {
  std::optional<Shown> finest;
  for (int coarser = 0; coarser < 3; ++coarser) {
    Matches matches = MatchFeatures(left, right, coarser);
    PairModel model = FitPair(matches, left.size());
    Shown shown{std::move(matches), std::move(model)};
    if (ShowOneScene(shown.model)) return shown;
    if (!finest) finest = std::move(shown);
  }
  return std::move(*finest);
}

}  // namespace

Findings CheckInputs(const cv::Mat1b& left, const cv::Mat1b& right, const TofImage& tof,
                     const RectifiedPair& pair, const TofProjector* projector) {
  if (left.size() != pair.size() || right.size() != pair.size()) {
    return NoneCanTell("images of " + SizeText(left.size()) + " and " + SizeText(right.size()) +
                       ": allowed is the calibrated size " + SizeText(pair.size()));
  }
  const auto [matches, model] = MatchLevels(left, right);
  std::optional<RangeModel> ranges;
  if (projector != nullptr) ranges = CompareRanges(model.inliers, tof, *projector);
  Findings findings = JudgePair(left, right, pair, matches, model, ranges ? &*ranges : nullptr);
  const bool only_rows = ranges && OnlyRowsAreOff(model, left.cols, *ranges);
  // Matches are right with different contrasts, too.
  const bool fits = std::ranges::none_of(findings, [&](const Finding& finding) {
    return finding.verdict == Verdict::kBad && finding.question != Question::kContrast &&
           !(finding.question == Question::kRows && only_rows);
  });
  for (Finding& finding : JudgeRanges(ranges ? &*ranges : nullptr, fits)) {
    if (ranges && !fits) SayGross(*ranges, finding);
    if (finding.question == Question::kScale) SayUnlikely(pair, finding);
    findings.push_back(std::move(finding));
  }
  if (ranges && fits) SayResizedRanges(projector->rig(), findings);
  return findings;
}

Findings CheckInputs(const cv::Mat& left, const cv::Mat& right, const TofImage& tof,
                     const Rig& rig) {
  const auto is_image = [](const cv::Mat& image) {
    return image.type() == CV_8UC1 || image.type() == CV_8UC3;
  };
  if (!is_image(left) || !is_image(right)) {
    return NoneCanTell("images of another type than 8 bit, grey or BGR");
  }
  const Rig of_frame = RigOfFrame(rig, tof);
  if (const Result<void> size = CheckTofSize(of_frame, tof); !size) {
    return NoneCanTell(size.error().text);
  }
  std::optional<TofProjector> projector;
  if (!tof.depth_m.empty()) projector.emplace(of_frame);
  return CheckInputs(ToGrey(left), ToGrey(right), tof, rig.pair, projector ? &*projector : nullptr);
}

}  // namespace sprout::inputs
