// Compiled by Highway once for each instruction set; one of them is picked when the program runs.
#include <algorithm>
#include <cmath>
#include <cstdint>

#include "services/prior/triangulation/interpolation.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "services/prior/triangulation/paint_kernel.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace sprout::prior {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

// Twice the area of a triangle, px²; negative where it runs the other way round.
double TwiceArea(const Corners& corners) {
  const auto& [a, b, c] = corners;
  return (double{b.u} - a.u) * (double{c.v} - a.v) - (double{c.u} - a.u) * (double{b.v} - a.v);
}

// Eq. (P4): the plane through the disparities of the corners.
Plane PlaneThrough(const Corners& corners, double twice_area) {
  constexpr double kSteepest = 1e6;  // of slivers, whose pixels are clamped to the corners
  const auto& [a, b, c] = corners;
  const double bd = double{b.disparity} - a.disparity;
  const double cd = double{c.disparity} - a.disparity;
  const double per_column = (bd * (double{c.v} - a.v) - cd * (double{b.v} - a.v)) / twice_area;
  const double per_row = (cd * (double{b.u} - a.u) - bd * (double{c.u} - a.u)) / twice_area;
  Plane plane = a;
  plane.per_column = static_cast<float>(std::clamp(per_column, -kSteepest, kSteepest));
  plane.per_row = static_cast<float>(std::clamp(per_row, -kSteepest, kSteepest));
  return plane;
}

// Eq. (P8).
double SigmaPx(const Corners& corners, double edge_px) {
  const auto& [a, b, c] = corners;
  const float u = (a.u + b.u + c.u) / 3;
  const float v = (a.v + b.v + c.v) / 3;
  const float disparity = (a.disparity + b.disparity + c.disparity) / 3;
  double squares = 0;
  for (const Plane& corner : corners) {
    const double off = double{corner.At(u, v)} - disparity;
    squares += double{corner.sigma_px} * corner.sigma_px;
    if (std::abs(off) < edge_px) squares += off * off;
  }
  return std::sqrt(squares / 3);
}

// The same runs as ForEachRun() finds, several rows at once.
class Runs {
 public:
  static constexpr int kRows = static_cast<int>(hn::MaxLanes(hn::CappedTag<double, 8>()));

  Runs(const Corners& corners, int width, const cv::Range& rows)
      : width_(width), sides_(corners, rows) {}

  int first() const { return sides_.first; }
  int end() const { return sides_.end; }

  // Columns [begins, ends) of kRows rows from v on.
  HWY_INLINE void At(int v, int32_t* begins, int32_t* ends) const {
    const D d;
    const auto rows = hn::Add(hn::Set(d, v), hn::Iota(d, 0));
    const auto side = [&](const Plane& from, double slope) HWY_ATTR {
      const auto down = hn::Sub(rows, hn::Set(d, double{from.v}));
      return hn::Add(hn::Set(d, double{from.u}), hn::Mul(down, hn::Set(d, slope)));
    };
    const auto one = side(*sides_.top, sides_.long_slope);
    const auto is_upper = hn::Lt(rows, hn::Set(d, double{sides_.middle->v}));
    const auto other = hn::IfThenElse(is_upper, side(*sides_.top, sides_.upper_slope),
                                      side(*sides_.middle, sides_.lower_slope));
    const auto slack = hn::Set(d, kSideSlack);
    StoreBehind(hn::Sub(hn::Min(one, other), slack), begins);
    StoreBehind(hn::Add(hn::Max(one, other), slack), ends);
  }

 private:
  using D = hn::CappedTag<double, 8>;

  // The next columns to the right of what is given.
  HWY_INLINE void StoreBehind(hn::Vec<D> columns, int32_t* to) const {
    const D d;
    const hn::Rebind<int32_t, D> d32;
    const auto inside = hn::Min(hn::Max(columns, hn::Set(d, -1)), hn::Set(d, width_ - 1));
    hn::StoreU(hn::DemoteTo(d32, hn::Add(inside, hn::Set(d, 1))), d32, to);
  }

  int width_;
  Sides sides_;
};

// Paints a triangle.
class Paint {
 public:
  Paint(const Corners& corners, double twice_area, double edge_px, PriorMap& map)
      : plane_(PlaneThrough(corners, twice_area)),
        sigma_(SigmaToCounts(SigmaPx(corners, edge_px))),
        width_(map.disparity.width()),
        map_(map) {
    constexpr float kMaxPx = DisparityImage::kMaxPx;
    const auto& [a, b, c] = corners;
    const auto [least, most] = std::minmax({a.disparity, b.disparity, c.disparity});
    low_ = kOne * std::clamp(least, 0.F, kMaxPx);
    high_ = kOne * std::clamp(most, 0.F, kMaxPx);
  }

  // Columns [begins[i], ends[i]) of row v + i, for `count` rows.
  HWY_INLINE void Rows(int v, int count, const int32_t* begins, const int32_t* ends) const {
    float firsts[Runs::kRows];
    StoreFirsts(v, begins, firsts);
    for (int i = 0; i < count; ++i) Run(v + i, begins[i], ends[i], firsts[i]);
  }

 private:
  static constexpr int kAtOnce = 8;  // most runs are shorter: a loop whose end can be foreseen
  using D = hn::CappedTag<float, kAtOnce>;
  static constexpr int kLanes = static_cast<int>(hn::MaxLanes(D()));
  static constexpr float kOne = DisparityImage::kCountsPerPixel;

  // Counts in the first columns, as Plane::At() has them.
  HWY_INLINE void StoreFirsts(int v, const int32_t* begins, float* firsts) const {
    const hn::CappedTag<float, Runs::kRows> d;
    const hn::RebindToSigned<decltype(d)> d32;
    static_assert(hn::MaxLanes(d) == Runs::kRows);
    const auto across = hn::Sub(hn::ConvertTo(d, hn::LoadU(d32, begins)), hn::Set(d, plane_.u));
    const auto down = hn::Sub(hn::ConvertTo(d, hn::Iota(d32, v)), hn::Set(d, plane_.v));
    const auto along_row = hn::Mul(hn::Set(d, plane_.per_column), across);
    const auto along_column = hn::Mul(hn::Set(d, plane_.per_row), down);
    const auto px = hn::Add(hn::Add(hn::Set(d, plane_.disparity), along_row), along_column);
    hn::StoreU(hn::Mul(hn::Set(d, kOne), px), d, firsts);
  }

  HWY_INLINE void Run(int v, int begin, int end, float first) const {
    int16_t* const counts = map_.disparity.counts()[v];
    uint8_t* const sigmas = map_.sigma[v];
    for (int u = begin; u < end; u += kAtOnce) {
      if (u + kAtOnce <= width_) {
        Pixels(first, u - begin, end - u, counts + u, sigmas + u);
        continue;
      }
      int16_t few_counts[kAtOnce];
      uint8_t few_sigmas[kAtOnce];
      Pixels(first, u - begin, end - u, few_counts, few_sigmas);
      std::copy_n(few_counts, end - u, counts + u);
      std::copy_n(few_sigmas, end - u, sigmas + u);
    }
  }

  // Pixels `from` to from + kAtOnce of a run. Behind its last, `count`, the row stays as it is.
  HWY_INLINE void Pixels(float first, int from, int count, int16_t* counts, uint8_t* sigmas) const {
    const D d;
    const hn::Rebind<int32_t, D> d32;
    const hn::Rebind<int16_t, D> d16;
    const hn::CappedTag<uint8_t, kAtOnce> d8;
    constexpr int kLanes8 = static_cast<int>(hn::MaxLanes(d8));
    const int in_run = std::min(count, kAtOnce);
    const auto blend = [](auto is_in_run, auto value, auto narrow, auto* row) HWY_ATTR {
      hn::StoreU(hn::IfThenElse(is_in_run, value, hn::LoadU(narrow, row)), narrow, row);
    };
    HWY_UNROLL(kAtOnce / kLanes)
    for (int i = 0; i < kAtOnce; i += kLanes) {
      const auto steps = hn::ConvertTo(d, hn::Iota(d32, from + i));
      const auto plane =
          hn::Add(hn::Set(d, first), hn::Mul(hn::Set(d, kOne * plane_.per_column), steps));
      const auto held = hn::Min(hn::Max(plane, hn::Set(d, low_)), hn::Set(d, high_));
      const auto whole = hn::ConvertTo(d32, hn::Add(held, hn::Set(d, 0.5F)));
      const auto is_in_run = hn::Lt(hn::Iota(d16, static_cast<int16_t>(i)),
                                    hn::Set(d16, static_cast<int16_t>(in_run)));
      blend(is_in_run, hn::DemoteTo(d16, whole), d16, counts + i);
    }
    HWY_UNROLL(kAtOnce / kLanes8)
    for (int i = 0; i < kAtOnce; i += kLanes8) {
      const auto is_in_run =
          hn::Lt(hn::Iota(d8, static_cast<uint8_t>(i)), hn::Set(d8, static_cast<uint8_t>(in_run)));
      blend(is_in_run, hn::Set(d8, sigma_), d8, sigmas + i);
    }
  }

  Plane plane_;
  float low_, high_;  // counts
  uint8_t sigma_;
  int width_;
  PriorMap& map_;
};

void PaintTriangle(const Corners& corners, double edge_px, const cv::Range& rows, PriorMap& map) {
  constexpr double kMinArea = 1e-3;  // px², twice; holds no pixel that others do not have
  const double twice_area = TwiceArea(corners);
  if (std::abs(twice_area) < kMinArea) return;
  const Paint paint(corners, twice_area, edge_px, map);
  const Runs runs(corners, map.disparity.width(), rows);
  int32_t begins[Runs::kRows], ends[Runs::kRows];
  for (int v = runs.first(); v < runs.end(); v += Runs::kRows) {
    runs.At(v, begins, ends);
    paint.Rows(v, std::min(Runs::kRows, runs.end() - v), begins, ends);
  }
}

}  // namespace

void PaintOnTarget(std::span<const Plane> planes, std::span<const SeedTriangle> triangles,
                   std::span<const int> chosen, double edge_px, const cv::Range& rows,
                   PriorMap& map) {
  for (int i : chosen) {
    PaintTriangle(CornersOf(planes, triangles[static_cast<size_t>(i)]), edge_px, rows, map);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace sprout::prior
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sprout::prior {

HWY_EXPORT(PaintOnTarget);

void PaintTriangles(std::span<const Plane> planes, std::span<const SeedTriangle> triangles,
                    std::span<const int> chosen, double edge_px, const cv::Range& rows,
                    PriorMap& map) {
  HWY_DYNAMIC_DISPATCH(PaintOnTarget)(planes, triangles, chosen, edge_px, rows, map);
}

}  // namespace sprout::prior
#endif  // HWY_ONCE
