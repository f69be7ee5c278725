#include "services/pipeline/files/believe_nothing.h"

#include <fmt/core.h>

#include <limits>

#include "common/core/prior_map.h"

namespace sprout {

void BelieveNothing(const SproutConfig& config, DepthFrame& depth) {
  const bool has_confidence = !depth.confidence.empty();
  for (cv::Mat1b* confidence : {&depth.confidence, &depth.fused_confidence}) *confidence = 0;
  depth.sigma = kMaxSigmaCounts;
  const bool of_fused = config.depth().input() == DepthConfig::FUSED;
  const auto drop_all = [](DisparityImage& map) { map.counts() = DisparityImage::kInvalid; };
  if (!has_confidence) return;
  const bool drops = config.grow().min_confidence() > 0;
  if (drops) drop_all(depth.disparity);
  if (config.depth().min_confidence() > 0 || (drops && !of_fused)) {
    drop_all(depth.kept);
    depth.depth_m = std::numeric_limits<float>::quiet_NaN();
  }
}

std::string LeaveOutRanges(const inputs::Findings& findings, bool has_map_without, int width,
                           TofImage& tof) {
  std::string note;
  bool is_far = false;
  for (const inputs::Finding& finding : findings) {
    is_far |= finding.question == inputs::Question::kPlace &&
              finding.verdict == inputs::Verdict::kBad && finding.moved_px > width / 20.0;
    if (finding.no_return_m == 0) continue;
    tof.depth_m.setTo(0, tof.depth_m == finding.no_return_m);
    note = fmt::format("; ranges of exactly {:.3f} m are left out", finding.no_return_m);
  }
  using inputs::Question;
  const bool hits_is_bad = note.empty() && AnyIsBad(findings, {Question::kHits});
  const bool are_contradicted = AnyIsBad(findings, {Question::kRows, Question::kContrast}) &&
                                AnyIsBad(findings, {Question::kPlace, Question::kMoment});
  if (has_map_without && !tof.depth_m.empty() &&
      (is_far || hits_is_bad || are_contradicted || AnyIsBad(findings, {Question::kScale}))) {
    tof = TofImage();
    note = "; no range is believed";
  }
  return note;
}

}  // namespace sprout
