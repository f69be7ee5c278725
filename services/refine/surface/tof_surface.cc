#include "services/refine/surface/tof_surface.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <tuple>

#include "common/core/parallel.h"
#include "common/core/quantile.h"
#include "services/refine/surface/surface_rules.h"
#include "services/refine/surface/window_difference.h"

namespace sprout::refine {
namespace {

constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
constexpr size_t kMostPieces = SurfaceRules::kMostPieces;

// The smaller of two steps by magnitude: beside an edge the one that stays on the surface. A step
// to a pixel without a point is NaN and does not count.
float GentlerStep(float a, float b) {
  if (std::isnan(a)) return std::isnan(b) ? 0 : b;
  if (std::isnan(b)) return a;
  return std::abs(a) <= std::abs(b) ? a : b;
}

// An order of all points of a ToF image.
bool IsNearer(const ProjectedPoint& a, const ProjectedPoint& b) {
  const auto key = [](const ProjectedPoint& point) {
    return std::tuple(-point.seed.disparity(), point.tof_v, point.tof_u);
  };
  return key(a) < key(b);
}

}  // namespace

// Three of four returns have the next one as near as this along the columns and along the rows.
void TofSurface::SetSteps(const TofCamera& tof, std::span<const ProjectedPoint> points) {
  const auto step = [&] { return gaps_.empty() ? 1 : Quantile(gaps_, SurfaceRules::kWithNext); };
  gaps_.clear();
  for (size_t i = 1; i < points.size(); ++i) {  // they come row by row
    if (points[i].tof_v == points[i - 1].tof_v) {
      gaps_.push_back(points[i].tof_u - points[i - 1].tof_u);
    }
  }
  column_step_ = step();
  gaps_.clear();
  last_row_.assign(static_cast<size_t>(tof.width), -1);
  for (const ProjectedPoint& point : points) {
    int& last = last_row_[static_cast<size_t>(point.tof_u)];
    if (last >= 0) gaps_.push_back(point.tof_v - last);
    last = point.tof_v;
  }
  row_step_ = step();
}

void TofSurface::Set(const Rig& rig, std::span<const ProjectedPoint> points) {
  size_ = rig.pair.size();
  SetSteps(rig.tof, points);
  column_px_ = column_step_ * rig.pair.focal_px / rig.tof.fx;
  row_px_ = row_step_ * rig.pair.focal_px / rig.tof.fy;
  stride_ = rig.tof.width / column_step_ + 3;
  const int rows = rig.tof.height / row_step_ + 3;
  disparity_.assign(static_cast<size_t>(stride_) * static_cast<size_t>(rows), kNone);
  for (const ProjectedPoint& point : points) {
    float& cell = disparity_[IndexOf(point)];
    if (!(cell >= point.seed.disparity())) cell = point.seed.disparity();  // the nearest of several
  }
}

double TofSurface::NoisePx(std::span<const ProjectedPoint> points) {
  deviations_.clear();
  for (const ProjectedPoint& point : points) {
    const float* at = At(point);
    for (const std::ptrdiff_t step : {std::ptrdiff_t{1}, stride_}) {
      const float off = *at - (at[step] + at[-step]) / 2;
      if (!std::isnan(off)) deviations_.push_back(std::abs(off));
    }
  }
  if (deviations_.empty()) return 0;
  using Rules = SurfaceRules;
  return Quantile(deviations_, Rules::kNoiseShare) /
         (Rules::kNoiseQuantile * std::sqrt(Rules::kNoiseVariance));
}

bool TofSurface::IsIsolated(const ProjectedPoint& point, double tolerance_px) const {
  const float here = point.seed.disparity();
  int support = 0;
  for (int down = -1; down <= 1; ++down) {
    const float* row = At(point) + down * stride_;
    for (int across = -1; across <= 1; ++across) {
      if (down == 0 && across == 0) continue;
      support += std::abs(row[across] - here) <= tolerance_px ? 1 : 0;
    }
  }
  return support < SurfaceRules::kSupport;
}

bool TofSurface::IsConfirmed(const ProjectedPoint& point, double tolerance_px,
                             const cv::Mat1b& left, const cv::Mat1b& right) const {
  const Seed& seed = point.seed;
  const double own =
      SurfaceRules::kMuchBetter * WindowDifference(left, right, seed.u, seed.v, seed.u_right);
  bool compared = false;
  for (int down = -1; down <= 1; ++down) {
    const float* row = At(point) + down * stride_;
    for (int across = -1; across <= 1; ++across) {
      const double elsewhere = row[across];
      if (!(std::abs(elsewhere - seed.disparity()) > tolerance_px)) continue;
      if (own >= WindowDifference(left, right, seed.u, seed.v, seed.u - elsewhere)) return false;
      compared = true;
    }
  }
  return compared;
}

TofSurface::Piece TofSurface::PieceOf(const ProjectedPoint& point) const {
  const float* at = At(point);
  const float here = point.seed.disparity();
  return {point.seed.disparity(), GentlerStep(at[1] - here, here - at[-1]),
          GentlerStep(at[stride_] - here, here - at[-stride_])};
}

// One point against the pieces around it.
class TofSurface::HiddenTest {
 public:
  HiddenTest(const TofSurface& surface, std::span<const ProjectedPoint> points,
             const cv::Mat1b& left, const cv::Mat1b& right, const HiddenRule& rule)
      : surface_(surface), points_(points), left_(left), right_(right), rule_(rule) {}

  bool IsHiddenIn(const View& view, size_t i) const {
    Point point{.index = i,
                .furthest_px = points_[i].seed.disparity() + rule_.tolerance_px,
                .difference = {}};
    return view.cells.AnyNeighbour(view.positions[i],
                                   [&](size_t other) { return Hides(view, other, point); });
  }

 private:
  struct Point {
    size_t index;
    double furthest_px;                // that a piece may lie and hide nothing
    std::optional<double> difference;  // of the images there, once it was asked for
  };

  // Whether the piece of a point hides another one.
  bool Hides(const View& view, size_t by, Point& point) const {
    // From the one to the other, in ToF pixels.
    const cv::Point2f& from = view.positions[by];
    const cv::Point2f& to = view.positions[point.index];
    const double across = (double{to.x} - from.x) / surface_.column_px_;
    const double down = (double{to.y} - from.y) / surface_.row_px_;
    const double distance = std::max(std::abs(across), std::abs(down));
    if (distance > rule_.reach) return false;
    const Piece& piece = surface_.pieces_[by];
    const double piece_px = piece.disparity + across * piece.across + down * piece.down;
    if (piece_px <= point.furthest_px) return false;
    if (distance <= rule_.core) return true;
    // The piece at this pixel: what it would be in the other image.
    const Seed& seed = points_[point.index].seed;
    const bool is_left = &view == &surface_.left_;
    const double u = is_left ? seed.u : seed.u_right + piece_px;
    const double u_right = is_left ? seed.u - piece_px : seed.u_right;
    if (!point.difference) point.difference = Difference(seed.u, seed.v, seed.u_right);
    return SurfaceRules::kClearlyBetter * Difference(u, seed.v, u_right) < *point.difference;
  }

  double Difference(double u, double v, double u_right) const {
    return WindowDifference(left_, right_, u, v, u_right);
  }

  const TofSurface& surface_;
  std::span<const ProjectedPoint> points_;
  const cv::Mat1b& left_;
  const cv::Mat1b& right_;
  const HiddenRule& rule_;
};

const std::vector<Hidden>& TofSurface::FindHidden(std::span<const ProjectedPoint> points,
                                                  size_t in_both, const cv::Mat1b& left,
                                                  const cv::Mat1b& right, const HiddenRule& rule) {
  hidden_.assign(points.size(), {});
  if (rule.reach <= 0) return hidden_;
  const double cell_px =
      std::max(SurfaceRules::kSmallestCellPx, rule.reach * std::max(column_px_, row_px_));
  const auto look = [&](size_t count, float Seed::*column, View& view) {
    view.positions.clear();
    for (const auto& [u, v, seed] : points.first(count)) {
      view.positions.emplace_back(seed.*column, seed.v);
    }
    view.cells.Fill(view.positions, size_, cell_px, kMostPieces, [&](std::span<uint32_t> cell) {
      std::nth_element(cell.begin(), cell.begin() + kMostPieces, cell.end(),
                       [&](uint32_t a, uint32_t b) { return IsNearer(points[a], points[b]); });
      return kMostPieces;
    });
  };
  RunBoth(
      [&] {
        look(points.size(), &Seed::u, left_);
        pieces_.clear();
        for (const ProjectedPoint& point : points) {
          pieces_.push_back(PieceOf(point));
        }
      },
      [&] { look(in_both, &Seed::u_right, right_); });

  const HiddenTest test(*this, points, left, right, rule);
  ForEachParallel(points.size(), [&](size_t i) {
    hidden_[i] = {.from_left = test.IsHiddenIn(left_, i),
                  .from_right = i < in_both && test.IsHiddenIn(right_, i)};
  });
  return hidden_;
}

}  // namespace sprout::refine
