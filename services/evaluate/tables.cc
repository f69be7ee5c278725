#include "services/evaluate/tables.h"

#include <fmt/core.h>

#include <algorithm>
#include <iterator>

#include "services/evaluate/paper_figures.h"

namespace sprout::evaluate {
namespace {

using Row = std::vector<std::string>;

// The first row is the head; the first column stands left, all others right.
std::string Markdown(const std::vector<Row>& rows) {
  std::vector<size_t> widths(rows.front().size(), 3);
  for (const Row& row : rows) {
    for (size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  }
  std::string text;
  for (const Row& row : rows) {
    for (size_t i = 0; i < row.size(); ++i) {
      text += i == 0 ? fmt::format("| {:<{}} |", row[i], widths[i])
                     : fmt::format(" {:>{}} |", row[i], widths[i]);
    }
    text += "\n";
    if (&row != &rows.front()) continue;
    for (size_t i = 0; i < row.size(); ++i) {
      const std::string dashes(widths[i], '-');
      text += i == 0 ? "|-" + dashes + "-|" : "-" + dashes + ":|";
    }
    text += "\n";
  }
  return text;
}

std::string Fixed(double number, int digits) { return fmt::format("{:.{}f}", number, digits); }

// A stage that a method does not have.
std::string Milliseconds(double ms) { return ms == 0 ? "-" : Fixed(ms, 1); }

// Whether ToF points are near some of the pixels, but not all.
bool HasAway(const SceneResult& scene) {
  const MethodResult& any = scene.methods.front();
  return any.away.scored > 0 && any.away.scored < any.all.scored;
}

Row HeadRow(bool with_away) {
  Row row{"method",    "<= 1 px %", "< 1 px %", "bad 0.5 %", "bad 2 %",    "bad 4 %", "D1 %",
          "density %", "invalid %", "mean px",  "rms px",    "all <= 1 %", "all D1 %"};
  if (with_away) row.insert(row.end(), {"away <= 1 %", "away D1 %"});
  row.insert(row.end(), {"refine ms", "prior ms", "grow ms", "fill ms", "total ms"});
  return row;
}

Row MetricsRow(const MethodResult& method, bool with_away) {
  const Accuracy& score = method.nonoccluded;
  Row row{method.name,
          Fixed(score.correct_le1_percent(), 2),
          Fixed(score.correct_lt1_percent(), 2),
          Fixed(score.bad05_percent(), 2),
          Fixed(score.bad2_percent(), 2),
          Fixed(score.bad4_percent(), 2),
          Fixed(score.d1_percent(), 2),
          Fixed(score.density_percent(), 2),
          Fixed(score.invalid_percent(), 2),
          Fixed(score.mean_abs_px(), 3),
          Fixed(score.rms_px(), 3),
          Fixed(method.all.correct_le1_percent(), 2),
          Fixed(method.all.d1_percent(), 2)};
  if (with_away) {
    row.push_back(Fixed(method.away.correct_le1_percent(), 2));
    row.push_back(Fixed(method.away.d1_percent(), 2));
  }
  for (const double ms : {method.ms.refine_ms, method.ms.prior_ms, method.ms.grow_ms,
                          method.ms.fill_ms, method.ms.total_ms}) {
    row.push_back(Milliseconds(ms));
  }
  return row;
}

std::string RefinementLine(const RefinementQuality& quality) {
  const SeedSet& seeds = quality.refined;
  const int32_t kept = CountTofSeeds(seeds.seeds);
  return fmt::format(
      "refinement: {} ToF points, dropped {} outside, {} dark, {} loose, {} background, {} "
      "hidden, {} contradicted; {} kept, {} from stereo; wrong {:.2f} % before, {:.2f} % after; "
      "good ones lost {:.2f} %\n",
      seeds.raw, seeds.outside, seeds.dark, seeds.loose, seeds.background, seeds.hidden,
      seeds.contradicted, kept, std::ssize(seeds.seeds) - kept, quality.wrong_before_percent(),
      quality.wrong_after_percent(), quality.good_lost_percent());
}

std::string ConfidenceLine(const MethodResult& method) {
  const Sparsification& curve = *method.confidence;
  std::string line = fmt::format("confidence of {}: bad 1 ", method.name);
  for (const int kept_percent : {100, 95, 90, 80, 50}) {
    line += fmt::format(
        "{:.2f} % of {}, ", curve.BestPercent(kept_percent),
        kept_percent == 100 ? "all pixels" : fmt::format("the best {} %", kept_percent));
  }
  return line + fmt::format("best 70 % / all {:.2f}, area {:.3f} (oracle {:.3f})\n",
                            curve.BestPercent(70) / curve.BestPercent(100), curve.area_percent,
                            curve.oracle_area_percent);
}

std::string CalibrationLine(const MethodResult& method) {
  const Calibration& calibration = *method.calibration;
  return fmt::format(
      "calibration of {}: error > 1 px claimed {:.2f} %, true {:.2f} %, calibration error {:.2f} "
      "points; within sigma {:.1f} %, within 2 sigma {:.1f} %\n",
      method.name, calibration.claimed_percent, calibration.bad1_percent, calibration.error_points,
      calibration.within_1_sigma_percent, calibration.within_2_sigma_percent);
}

// Measured, the paper's, difference.
Row PaperCells(const SceneResult& scene, const MethodResult& method) {
  const double measured = method.nonoccluded.correct_le1_percent();
  const double paper = PaperPercent(scene.name, method.name).value();
  return {Fixed(measured, 1), Fixed(paper, 1), fmt::format("{:+.1f}", measured - paper)};
}

bool IsInPaper(const SceneResult& scene, const MethodResult& method) {
  return PaperPercent(scene.name, method.name).has_value();
}

bool HasPaperMethod(const SceneResult& scene) {
  return std::ranges::any_of(scene.methods,
                             [&](const MethodResult& method) { return IsInPaper(scene, method); });
}

}  // namespace

std::string SceneTable(const SceneResult& scene) {
  const bool with_away = HasAway(scene);
  std::vector<Row> rows{HeadRow(with_away)};
  for (const MethodResult& method : scene.methods) rows.push_back(MetricsRow(method, with_away));
  std::string text =
      fmt::format("{} ({} x {} px)\n\n", scene.name, scene.size.width, scene.size.height) +
      Markdown(rows) + "\n" + RefinementLine(scene.refinement);
  for (const MethodResult& method : scene.methods) {
    // The paper's variants have one, too, which nobody asks for.
    if (!method.name.starts_with("sprout") || !method.confidence) continue;
    text += ConfidenceLine(method);
    if (method.calibration) text += CalibrationLine(method);
  }
  return text;
}

std::string PaperTable(std::vector<SceneResult> scenes) {
  std::erase_if(scenes, [](const SceneResult& scene) { return !HasPaperMethod(scene); });
  if (scenes.empty()) return "";
  std::vector<Row> rows{{"method"}};
  for (const SceneResult& scene : scenes) {
    for (const std::string& head : {scene.name, std::string("paper"), std::string("diff")}) {
      rows.front().push_back(head);
    }
  }
  for (size_t i = 0; i < scenes.front().methods.size(); ++i) {  // the same ones in every scene
    const MethodResult& method = scenes.front().methods[i];
    if (!IsInPaper(scenes.front(), method)) continue;
    Row row{method.name};
    for (const SceneResult& scene : scenes) {
      std::ranges::copy(PaperCells(scene, scene.methods[i]), std::back_inserter(row));
    }
    rows.push_back(row);
  }
  return "Correct non-occluded pixels (error <= 1 px), %, beside the paper's figures\n\n" +
         Markdown(rows);
}

}  // namespace sprout::evaluate
