#include "services/refine/surface/tof_surface.h"

#include "common/core/quantile.h"
#include "common/core/window_sums.h"
#include "services/refine/surface/plane_sums.h"

namespace sprout::refine {
namespace {

double Difference(const cv::Mat1b& left, const cv::Mat1b& right, cv::Point at_left,
                  cv::Point at_right) {
  const WindowSums sums = SumWindows<SurfaceRules::kRadius>(left, right, at_left, at_right);
  const int32_t squares = sums.left_squares + sums.right_squares;
  return squares == 0 ? 0 : static_cast<double>(squares - 2 * sums.products) / squares;
}

// The slopes a cell of the plane through cells; 0 where all lie on one line. @pre sums.n > 0.
cv::Point2d SlopeOf(const PlaneSums& sums) {
  SlopeSums centred(0);
  centred.xx = sums.slopes.xx - sums.x * sums.x / sums.n;
  centred.yy = sums.slopes.yy - sums.y * sums.y / sums.n;
  centred.xy = sums.slopes.xy - sums.x * sums.y / sums.n;
  centred.xd = sums.slopes.xd - sums.x * sums.d / sums.n;
  centred.yd = sums.slopes.yd - sums.y * sums.d / sums.n;
  return centred.Determinant() > 1e-2 ? centred.Slope() : cv::Point2d();
}

}  // namespace

double WindowDifference(const cv::Mat1b& left, const cv::Mat1b& right, double u, double v,
                        double u_right) {
  double best = std::numeric_limits<double>::infinity();
  constexpr double kMargin = SurfaceRules::kRadius - 0.5;
  if (!IsInside(u, v, left.size(), kMargin)) return best;
  const int row = static_cast<int>(std::lround(v));
  const cv::Point at_left(static_cast<int>(std::lround(u)), row);
  for (const double shifted : {u_right - 1, u_right, u_right + 1}) {
    if (!IsInside(shifted, v, right.size(), kMargin)) continue;
    const cv::Point at_right(static_cast<int>(std::lround(shifted)), row);
    best = std::min(best, Difference(left, right, at_left, at_right));
  }
  return best;
}

// How far the next return lies below, for three of four: in the same column of the ToF image, or in
// the same columns of several.
int TofSurface::RowStep(const TofCamera& tof, std::span<const ProjectedPoint> points, int columns) {
  gaps_.clear();
  last_row_.assign(static_cast<size_t>(tof.width / columns + 1), -1);
  for (const ProjectedPoint& point : points) {
    int& last = last_row_[static_cast<size_t>(point.tof_u / columns)];
    if (last >= 0) gaps_.push_back(point.tof_v - last);
    last = point.tof_v;
  }
  return gaps_.empty() ? 1 : Quantile(gaps_, SurfaceRules::kWithNext);
}

void TofSurface::SetSteps(const TofCamera& tof, std::span<const ProjectedPoint> points) {
  gaps_.clear();
  for (size_t i = 1; i < points.size(); ++i) {  // they come row by row
    if (points[i].tof_v == points[i - 1].tof_v) {
      gaps_.push_back(points[i].tof_u - points[i - 1].tof_u);
    }
  }
  column_step_ = gaps_.empty() ? 1 : Quantile(gaps_, SurfaceRules::kWithNext);
  row_step_ = RowStep(tof, points, 1);
  // The next beam's points of a lidar need not lie in the same column.
  next_row_ = column_step_ == 1 ? row_step_ : std::max(1, RowStep(tof, points, column_step_));
  if (has_pixels()) return;
  const double crowd = PointsPerCell(tof, points);
  if (crowd <= SurfaceRules::kCrowd) return;
  const double part = std::sqrt(SurfaceRules::kScatteredPerCell / crowd);
  const auto smaller = [&](int step) {
    return std::max(1, static_cast<int>(std::lround(part * step)));
  };
  column_step_ = smaller(column_step_);
  row_step_ = next_row_ = smaller(row_step_);
}

// The mean over the cells that have points.
double TofSurface::PointsPerCell(const TofCamera& tof, std::span<const ProjectedPoint> points) {
  const int columns = tof.width / column_step_ + 1;
  filled_.assign(static_cast<size_t>(columns * (tof.height / row_step_ + 1)), 0);
  size_t cells = 0;
  for (const ProjectedPoint& point : points) {
    const cv::Point cell = CellOf(point);
    uint8_t& filled = filled_[static_cast<size_t>(cell.y * columns + cell.x)];
    if (filled == 0) ++cells;
    filled = 1;
  }
  return static_cast<double>(points.size()) / static_cast<double>(std::max<size_t>(1, cells));
}

void TofSurface::Set(const Rig& rig, std::span<const ProjectedPoint> points) {
  size_ = rig.pair.size();
  noise_.reset();
  infinity_px_ = rig.pair.cx - rig.pair.cx_right;
  SetSteps(rig.tof, points);
  column_px_ = column_step_ * rig.pair.focal_px / rig.tof.fx;
  row_px_ = row_step_ * rig.pair.focal_px / rig.tof.fy;
  next_row_px_ = next_row_ * rig.pair.focal_px / rig.tof.fy;
  piece_px_ = {std::max(column_px_, spacing_px() / SurfaceRules::kPieces),
               std::max(next_row_px_, spacing_px() / SurfaceRules::kPieces)};
  tof_rows_ = rig.tof.height;
  stride_ = rig.tof.width / column_step_ + 3;
  rows_ = rig.tof.height / row_step_ + 1;
  disparity_.assign(static_cast<size_t>(stride_) * static_cast<size_t>(rows_ + 2), kNone);
  for (const ProjectedPoint& point : points) {
    float& cell = disparity_[IndexOf(point)];
    if (!(cell >= point.seed.disparity())) cell = point.seed.disparity();  // the nearest of several
  }
}

const RangeNoise& TofSurface::Noise(std::span<const ProjectedPoint> points) {
  if (noise_) return *noise_;
  deviations_.clear();
  const double least_px = std::min(column_px_, row_px_);
  const auto shape_px = [&](double step_px) {
    return static_cast<float>(SurfaceRules::kShapePerPx * (step_px - least_px));
  };
  for (const ProjectedPoint& point : points) {
    const float* at = At(point);
    const auto off_px = [&](std::ptrdiff_t step, double step_px) {
      return std::abs(*at - (at[step] + at[-step]) / 2) - shape_px(step_px);
    };
    const float off = std::fmax(off_px(1, column_px_), off_px(stride_, row_px_));  // or that known
    if (std::isnan(off)) continue;
    deviations_.push_back(
        {.disparity_px = *at, .off_px = std::max(0.0F, off), .block = BlockOf(point)});
  }
  constexpr int kSide = SurfaceRules::kBlockCells;
  block_noise_px_ = NoiseOfBlocks(
      deviations_, static_cast<size_t>((columns() / kSide + 1) * (rows_ / kSide + 1)));
  return noise_.emplace(FindRangeNoise(deviations_, infinity_px_));
}

double TofSurface::NoisePxAt(const ProjectedPoint& point, const RangeNoise& noise) const {
  const double of_frame_px = noise.PxAt(point.seed.disparity());
  const double around_px = block_noise_px_[BlockOf(point)];
  const bool is_noisy =
      around_px > std::max(SurfaceRules::kNoisyBlockPx, SurfaceRules::kNoisyBlock * of_frame_px);
  return is_noisy ? around_px : of_frame_px;
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

TofSurface::Plane TofSurface::PlaneOf(const ProjectedPoint& point, double tolerance_px) const {
  const float* const at = At(point);
  const float here = point.seed.disparity();
  // Beside an edge the gentler step is the one that stays on the surface.
  const auto step = [&](std::ptrdiff_t next) {
    const float gentler = Gentler(at[next] - here, here - at[-next]);
    return std::isnan(gentler) ? 0.0 : double{gentler};
  };
  const double rise_across = step(1);
  const double rise_down = step(stride_);
  Plane plane;
  PlaneSums sums(1e-3);  // of what the cells around are off the plane of the gentlest steps
  for (int down = -1; down <= 1; ++down) {
    const float* row = at + down * stride_;
    for (int across = -1; across <= 1; ++across) {
      const double off =
          double{row[across]} - double{here} - across * rise_across - down * rise_down;
      if (std::isnan(off)) continue;
      if (std::abs(off) > tolerance_px) {
        (off > 0 ? plane.has_nearer : plane.has_farther) = true;
        continue;
      }
      sums.Add(1, across, down, off);
    }
  }
  // A nearer point of its cell stands in for it, and nothing else lies on its surface.
  if (sums.n == 0) {
    plane.disparity = double{here};
    return plane;
  }
  const cv::Point2d slope = SlopeOf(sums);
  plane.disparity = double{here} + (sums.d - slope.x * sums.x - slope.y * sums.y) / sums.n;
  plane.slope = {(rise_across + slope.x) / column_px_, (rise_down + slope.y) / row_px_};
  return plane;
}

}  // namespace sprout::refine
