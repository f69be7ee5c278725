#include "services/tools/evaluate/confidence_diagram.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "common/picture/html.h"

namespace sprout::evaluate {
namespace {

// px; of a plot, and of what stands around it.
constexpr double kPlot = 260;
constexpr double kMargin = 56;
constexpr double kRow = kPlot + 2 * kMargin;

struct Place {
  double x = 0;  // per cent
  double y = 0;
};
using Curve = std::vector<Place>;

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

double MostOf(const std::vector<Curve>& curves) {
  double most = 0;
  for (const Curve& curve : curves) {
    for (const Place& place : curve) most = std::max(most, place.y);
  }
  return most;
}

// The end of an axis.
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
  for (const Place& place : curve) {
    oracle.push_back({place.x, 100 * std::max(0.0, place.x - (100 - bad)) / place.x});
  }
  return oracle;
}

class Plot {
 public:
  // @param right, top  numbers at the ends of the axes.
  Plot(Place corner, double right, double top) : corner_(corner), right_(right), top_(top) {}

  std::string Axes(const std::string& along, const std::string& up) const {
    std::string svg = fmt::format(
        "<rect class=\"axis\" x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\"/>",
        corner_.x, corner_.y, kPlot, kPlot);
    for (const double share : {0.0, 0.5, 1.0}) {
      svg += fmt::format(
          "<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"middle\">{:.4g}</text>"
          "<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"end\">{:.4g}</text>",
          corner_.x + share * kPlot, corner_.y + kPlot + 16, share * right_, corner_.x - 6,
          corner_.y + (1 - share) * kPlot + 4, share * top_);
    }
    return svg + fmt::format(
                     "<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"middle\">{}</text>"
                     "<text x=\"{:.1f}\" y=\"{:.1f}\">{}</text>",
                     corner_.x + kPlot / 2, corner_.y + kPlot + 34, along, corner_.x, corner_.y - 8,
                     up);
  }

  std::string Line(const Curve& curve, const char* style) const {
    std::string points;
    for (const Place& place : curve) {
      points += fmt::format("{}{:.1f},{:.1f}", points.empty() ? "" : " ",
                            corner_.x + std::min(place.x / right_, 1.0) * kPlot,
                            corner_.y + (1 - std::min(place.y / top_, 1.0)) * kPlot);
    }
    return fmt::format("<polyline class=\"{}\" points=\"{}\"/>", style, points);
  }

  std::string Lines(const std::vector<Curve>& scenes, const Curve& ideal) const {
    std::string svg;
    for (const Curve& curve : scenes) svg += Line(curve, "scene");
    return svg + Line(ideal, "ideal") + Line(MeanOf(scenes), "mean") + "\n";
  }

 private:
  Place corner_;
  double right_;
  double top_;
};

std::string ReliabilityPlot(const std::vector<Curve>& scenes, double y) {
  double most = MostOf(scenes);
  for (const Curve& curve : scenes) {
    for (const Place& place : curve) most = std::max(most, place.x);
  }
  most = RoundUp(most);
  const Plot plot({kMargin, y}, most, most);
  return plot.Axes("claimed share of errors &gt; 1 px, %", "true share, %") +
         plot.Lines(scenes, {{0, 0}, {most, most}});
}

std::string SparsificationPlot(const std::vector<Curve>& scenes, double y) {
  const Plot plot({kPlot + 3 * kMargin, y}, 100, RoundUp(MostOf(scenes)));
  return plot.Axes("pixels kept, the surest first, %", "errors &gt; 1 px among them, %") +
         plot.Lines(scenes, OracleOf(MeanOf(scenes)));
}

// The row of a method; empty when no scene has its confidence.
std::string RowOf(const std::vector<SceneResult>& scenes, size_t method, double y) {
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
  if (sparsification.empty()) return "";
  std::string svg = fmt::format("<text class=\"title\" x=\"{:.1f}\" y=\"{:.1f}\">{}</text>",
                                kMargin, y - 30, EscapedHtml(scenes[0].methods[method].name));
  if (!reliability.empty()) svg += ReliabilityPlot(reliability, y);
  return svg + SparsificationPlot(sparsification, y);
}

}  // namespace

std::string ConfidenceSvg(const std::vector<SceneResult>& scenes) {
  if (scenes.empty()) return "";
  std::string rows;
  double y = kMargin;
  for (size_t i = 0; i < scenes.front().methods.size(); ++i) {
    const std::string row = RowOf(scenes, i, y);
    if (row.empty()) continue;
    rows += row;
    y += kRow;
  }
  if (rows.empty()) return "";
  return fmt::format(
             "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0:.0f}\" height=\"{1:.0f}\" "
             "viewBox=\"0 0 {0:.0f} {1:.0f}\">\n"
             "<style>text {{ font: 12px sans-serif }} .title {{ font-size: 15px }} "
             "rect, polyline {{ fill: none }} .axis {{ stroke: #888 }} "
             ".scene {{ stroke: #bbb }} .mean {{ stroke: #06c; stroke-width: 2.5 }} "
             ".ideal {{ stroke: #c40; stroke-dasharray: 5 4 }}</style>\n"
             "<rect style=\"fill: #fff\" width=\"{0:.0f}\" height=\"{1:.0f}\"/>\n",
             2 * kPlot + 4 * kMargin, y - kMargin) +
         rows + "</svg>\n";
}

}  // namespace sprout::evaluate
