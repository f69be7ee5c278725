#include "common/measure/edge_width.h"

#include <cmath>
#include <optional>

#include "common/core/quantile.h"

namespace sprout {
namespace {

// Pixels of a line that have a disparity.
struct Point {
  float x;
  float d;
};
using Line = std::vector<Point>;

Line LineOf(const cv::Mat1f& lines, int row) {
  Line line;
  for (int x = 0; x < lines.cols; ++x) {
    const float d = lines(row, x);
    if (std::isfinite(d)) line.push_back({static_cast<float>(x), d});
  }
  return line;
}

// Medians of the outer quarters; nothing when one is empty.
struct Sides {
  float first;
  float last;
};

std::optional<Sides> SidesOf(const Line& line, int length) {
  std::vector<float> first, last;
  for (const Point& point : line) {
    if (point.x < static_cast<float>(length) / 4) first.push_back(point.d);
    if (point.x >= static_cast<float>(length) * 3 / 4) last.push_back(point.d);
  }
  if (first.empty() || last.empty()) return std::nullopt;
  return Sides{Median(first), Median(last)};
}

// Where the way from point i to point i + step passes `share`, which one is below and one not.
double Crossing(const std::vector<Point>& shares, size_t i, size_t next, double share) {
  const Point& a = shares[i];
  const Point& b = shares[next];
  return a.x + (b.x - a.x) * (share - a.d) / (b.d - a.d);
}

// Width of a rising line of shares: from the middle outwards to the first point at or beyond a
// share.
std::optional<double> WidthOf(const std::vector<Point>& shares) {
  const auto length = static_cast<float>(shares.back().x - shares.front().x);
  std::optional<size_t> middle;  // the crossing of 0.5 that is next to the middle of the line
  for (size_t i = 0; i + 1 < shares.size(); ++i) {
    if (shares[i].d >= 0.5F || shares[i + 1].d < 0.5F) continue;
    const auto off = [&](size_t k) {
      return std::abs(shares[k].x - shares.front().x - length / 2);
    };
    if (!middle || off(i) < off(*middle)) middle = i;
  }
  if (!middle) return std::nullopt;
  size_t low = *middle;
  while (low > 0 && shares[low].d > 0.1F) --low;
  size_t high = *middle + 1;
  while (high + 1 < shares.size() && shares[high].d < 0.9F) ++high;
  if (shares[low].d > 0.1F || shares[high].d < 0.9F) return std::nullopt;
  return Crossing(shares, high - 1, high, 0.9) - Crossing(shares, low, low + 1, 0.1);
}

double StepOf(const cv::Mat1f& lines) {
  std::vector<float> first, last;
  for (int row = 0; row < lines.rows; ++row) {
    const auto sides = SidesOf(LineOf(lines, row), lines.cols);
    if (!sides) continue;
    first.push_back(sides->first);
    last.push_back(sides->last);
  }
  return first.empty() ? 0 : std::abs(double{Median(last)} - double{Median(first)});
}

}  // namespace

EdgeWidths MeasureEdge(const cv::Mat1f& disparity_px) {
  cv::Mat1f turned;
  cv::transpose(disparity_px, turned);
  const cv::Mat1f& lines = StepOf(disparity_px) >= StepOf(turned) ? disparity_px : turned;
  EdgeWidths widths;
  for (int row = 0; row < lines.rows; ++row) {
    Line line = LineOf(lines, row);
    const auto sides = SidesOf(line, lines.cols);
    std::optional<double> width;
    if (sides && std::abs(sides->last - sides->first) >= kMinEdgeStepPx) {
      // Depths become shares of the step, rising from first to last.
      for (Point& point : line) point.d = (point.d - sides->first) / (sides->last - sides->first);
      width = WidthOf(line);
    }
    if (width) {
      widths.px.push_back(static_cast<float>(*width));
    } else {
      ++widths.without_edge;
    }
  }
  return widths;
}

}  // namespace sprout
