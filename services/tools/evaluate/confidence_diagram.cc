#include "services/tools/evaluate/confidence_diagram.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/picture/html.h"

namespace sprout::evaluate {
namespace {

using Curve = std::vector<cv::Point2d>;  // per cent

Curve MeanOf(const std::vector<Curve>& curves) {
  Curve mean(curves.front().size());
  const auto count = static_cast<double>(curves.size());
  for (const Curve& curve : curves) {
    for (size_t i = 0; i < mean.size(); ++i) {
      mean[i].x += curve[i].x / count;
      mean[i].y += curve[i].y / count;
    }
  }
  return mean;
}

double MaxOf(const std::vector<Curve>& curves) {
  double most = 0;
  for (const Curve& curve : curves) {
    for (const cv::Point2d& point : curve) most = std::max(most, point.y);
  }
  return most;
}

// The end of an axis that reaches to `percent`.
double RoundUp(double percent) {
  constexpr std::array kEnds = {1.0, 2.0, 5.0, 10.0, 20.0, 50.0};
  const auto* const end = std::ranges::lower_bound(kEnds, percent);
  return end == kEnds.end() ? 100 : *end;
}

Curve ReliabilityOf(const Calibration& calibration) {
  Curve curve;
  for (const Calibration::Bin& bin : calibration.bins) {
    curve.push_back({bin.claimed_percent, bin.bad1_percent});
  }
  return curve;
}

Curve SparsificationOf(const Sparsification& confidence) {
  Curve curve;
  for (size_t i = 0; i < confidence.bad1_percent.size(); ++i) {
    curve.push_back(
        {100 * static_cast<double>(i + 1) / Sparsification::kSteps, confidence.bad1_percent[i]});
  }
  return curve;
}

// The curve of a perfect ranking: among the best k % only those are wrong that remain when all good
// ones are taken.
Curve OracleOf(const Curve& curve) {
  const double bad = curve.back().y;
  Curve oracle;
  for (const cv::Point2d& point : curve) {
    oracle.push_back({point.x, 100 * std::max(0.0, point.x - (100 - bad)) / point.x});
  }
  return oracle;
}

std::vector<LinePlot::Line> Lines(const std::vector<Curve>& scenes, const Curve& ideal) {
  std::vector<LinePlot::Line> lines;
  for (const Curve& curve : scenes) lines.push_back({curve});
  lines.push_back({.points = ideal, .color = "#c40", .dashed = true});
  lines.push_back({.points = MeanOf(scenes), .color = "#06c", .width = 2.5});
  return lines;
}

LinePlot ReliabilityPlot(const std::string& title, const std::vector<Curve>& scenes) {
  double most = MaxOf(scenes);
  for (const Curve& curve : scenes) {
    for (const cv::Point2d& point : curve) most = std::max(most, point.x);
  }
  most = RoundUp(most);
  return {.title = title,
          .along = "claimed share of errors > 1 px, %",
          .up = "true share, %",
          .right = most,
          .top = most,
          .lines = Lines(scenes, {{0, 0}, {most, most}})};
}

LinePlot SparsificationPlot(const std::string& title, const std::vector<Curve>& scenes) {
  return {.title = title,
          .along = "pixels kept, the surest first, %",
          .up = "errors > 1 px among them, %",
          .right = 100,
          .top = RoundUp(MaxOf(scenes)),
          .lines = Lines(scenes, OracleOf(MeanOf(scenes)))};
}

// The row of a method; empty when no scene has its confidence.
std::vector<LinePlot> RowOf(const std::vector<SceneResult>& scenes, size_t method) {
  std::vector<Curve> reliability;
  std::vector<Curve> sparsification;
  for (const SceneResult& scene : scenes) {
    const MethodResult& result = scene.methods[method];
    if (result.calibration && !std::isnan(result.calibration->claimed_percent)) {
      reliability.push_back(ReliabilityOf(*result.calibration));
    }
    if (result.confidence && !std::isnan(result.confidence->bad1_percent.back())) {
      sparsification.push_back(SparsificationOf(*result.confidence));
    }
  }
  std::vector<LinePlot> row;
  if (sparsification.empty()) return row;
  const std::string& name = scenes[0].methods[method].name;
  if (!reliability.empty()) row.push_back(ReliabilityPlot(name, reliability));
  row.push_back(SparsificationPlot(name, sparsification));
  return row;
}

}  // namespace

std::string ConfidenceSvg(const std::vector<SceneResult>& scenes) {
  std::vector<std::vector<LinePlot>> rows;
  for (size_t i = 0; !scenes.empty() && i < scenes.front().methods.size(); ++i) {
    if (auto row = RowOf(scenes, i); !row.empty()) rows.push_back(std::move(row));
  }
  return rows.empty() ? "" : PlotsSvg(rows);
}

}  // namespace sprout::evaluate
