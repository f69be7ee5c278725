#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "services/evaluate/score.h"
#include "services/snapshot/snapshot.h"

namespace sprout::snapshot {
namespace {

// Stages in the order of the graph; others follow by name.
int OrderOf(const std::string& stage) {
  constexpr std::array kOrder = {"capture", "refine", "prior", "grow"};
  return static_cast<int>(std::find(kOrder.begin(), kOrder.end(), stage) - kOrder.begin());
}

// Share of the left image, per cent.
std::string CoverageText(float coverage) {
  return coverage == kUnknownCoverage ? "-" : fmt::format("{:.1f}", 100 * coverage);
}

std::string StageTable(const std::map<std::string, StageStatus>& statuses) {
  std::vector<StageStatus> stages;
  for (const auto& [name, status] : statuses) stages.push_back(status);
  std::stable_sort(stages.begin(), stages.end(), [](const StageStatus& a, const StageStatus& b) {
    return OrderOf(a.stage) < OrderOf(b.stage);
  });
  std::string text =
      fmt::format("{:<10}{:>9}{:>9}{:>9}{:>9}{:>8}{:>8}{:>10}{:>8}{:>6}{:>6}{:>8}{:>8}\n", "stage",
                  "time ms", "max ms", "age ms", "max ms", "frames", "skipped", "no result",
                  "failed", "gaps", "bad", "MB", "ToF %");
  for (const StageStatus& status : stages) {
    text += fmt::format(
        "{:<10}{:>9.1f}{:>9.1f}{:>9.1f}{:>9.1f}{:>8}{:>8}{:>10}{:>8}{:>6}{:>6}{:>8.0f}{:>8}\n",
        status.stage, status.latency.p50_ms, status.latency.max_ms, status.age.p50_ms,
        status.age.max_ms, status.frames_out, status.frames_skipped + status.frames_incomplete,
        status.frames_degenerate, status.frames_failed, status.sequence_gaps, status.bad_messages,
        static_cast<double>(status.rss_bytes) / 1e6, CoverageText(status.tof_coverage));
  }
  return text;
}

std::string SeedLine(const SeedSet& seeds) {
  const int32_t kept = CountTofSeeds(seeds.seeds);
  return fmt::format(
      "seeds: {} ToF points, dropped {} outside, {} dark, {} loose, {} background, {} hidden, {} "
      "contradicted; {} kept, {} from stereo\n",
      seeds.raw, seeds.outside, seeds.dark, seeds.loose, seeds.background, seeds.hidden,
      seeds.contradicted, kept, std::ssize(seeds.seeds) - kept);
}

Result<std::string> MapTable(const Frame& frame, const datasets::GroundTruth& truth) {
  std::vector<std::pair<const char*, const DisparityImage*>> maps = {
      {"prior", &frame.prior->disparity}};
  if (frame.unfilled) maps.emplace_back("grown", &*frame.unfilled);
  maps.emplace_back("filled", &*frame.disparity);
  std::string text = fmt::format("{:<10}{:>10}{:>22}\n", "map", "density %", "correct <= 1 px %");
  Result<cv::Mat1b> mask = cv::Mat1b();
  if (!truth.left.empty()) {
    mask = evaluate::NonOccludedMask(truth.left, truth.right);
    if (!mask) return tl::unexpected(mask.error());
  }
  for (const auto& [name, map] : maps) {
    const double density =
        100.0 * static_cast<double>(map->CountValid()) / static_cast<double>(map->counts().total());
    std::string correct = "unknown";
    if (!truth.left.empty()) {
      const Result<evaluate::Accuracy> accuracy = evaluate::Score(*map, truth.left, *mask);
      if (!accuracy) return tl::unexpected(accuracy.error());
      correct = fmt::format("{:.2f}", accuracy->correct_le1_percent());
    }
    text += fmt::format("{:<10}{:>10.2f}{:>22}\n", name, density, correct);
  }
  return text + "(correct: of the pixels that both cameras see; no disparity counts as wrong)\n";
}

}  // namespace

Result<std::string> ReportText(const Frame& frame,
                               const std::map<std::string, StageStatus>& statuses,
                               const datasets::GroundTruth& truth) {
  const Result<std::string> maps = MapTable(frame, truth);
  if (!maps) return maps;
  return StageTable(statuses) + "\n" + SeedLine(*frame.seeds) + "\n" + *maps;
}

}  // namespace sprout::snapshot
