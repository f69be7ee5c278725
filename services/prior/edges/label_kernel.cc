// Compiled by Highway once for each instruction set; one of them is picked when the program runs.
#include <algorithm>
#include <cstdint>

#include "services/prior/edges/edge_surfaces.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "services/prior/edges/label_kernel.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace sprout::prior {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

constexpr int kAtOnce = 8;  // most runs are shorter
using D = hn::CappedTag<float, kAtOnce>;
using V = hn::Vec<D>;
using D32 = hn::RebindToSigned<D>;
using D16 = hn::Rebind<int16_t, D>;
constexpr int kLanes = static_cast<int>(hn::MaxLanes(D()));

// The disparities of pixels side by side, each by the plane of the corner that is closest to it.
HWY_INLINE V DisparitiesAt(std::span<const Plane> planes, V u, float v) {
  const D d;
  V least = hn::Zero(d);
  V disparities = least;
  bool is_first = true;
  for (const Plane& plane : planes) {
    const V across = hn::Sub(u, hn::Set(d, plane.u));
    const float down = v - plane.v;
    const V distance = hn::Add(hn::Mul(across, across), hn::Set(d, down * down));
    const V along_row = hn::Mul(hn::Set(d, plane.per_column), across);
    const V here =
        hn::Add(hn::Add(hn::Set(d, plane.disparity), along_row), hn::Set(d, plane.per_row * down));
    const auto is_closer = hn::Lt(distance, least);
    least = is_first ? distance : hn::Min(distance, least);
    disparities = is_first ? here : hn::IfThenElse(is_closer, here, disparities);
    is_first = false;
  }
  return disparities;
}

// The counts of ToCounts(), but never beyond infinity, and faster.
HWY_INLINE hn::Vec<D32> NearestCounts(V disparities) {
  const D d;
  const V held = hn::Min(hn::Max(hn::Zero(d), disparities), hn::Set(d, DisparityImage::kMaxPx));
  constexpr float kOne = DisparityImage::kCountsPerPixel;
  return hn::ConvertTo(D32(), hn::Add(hn::Mul(held, hn::Set(d, kOne)), hn::Set(d, 0.5F)));
}

// Pixels of a row of the labels.
struct LabelRow {
  int16_t *near, *far;
  int* triangle;
};

class LabelPaint {
 public:
  LabelPaint(const EdgeTriangle& edge, int number, float least_gap_px, EdgeLabels& labels)
      : edge_(edge), number_(number), least_gap_px_(least_gap_px), labels_(labels) {}

  void Run(int v, int begin, int end) const {
    const int width = labels_.near.cols;
    for (int u = begin; u < end; u += kLanes) {
      const LabelRow row{&labels_.near(v, u), &labels_.far(v, u), &labels_.triangle(v, u)};
      if (u + kLanes <= width) {
        Pixels(u, v, end - u, row);
        continue;
      }
      int16_t near[kLanes] = {}, far[kLanes] = {};
      int triangle[kLanes] = {};
      std::copy_n(row.near, end - u, near);
      std::copy_n(row.far, end - u, far);
      std::copy_n(row.triangle, end - u, triangle);
      Pixels(u, v, end - u, {near, far, triangle});
      std::copy_n(near, end - u, row.near);
      std::copy_n(far, end - u, row.far);
      std::copy_n(triangle, end - u, row.triangle);
    }
  }

 private:
  // The first `count` of as many pixels as there are lanes.
  HWY_INLINE void Pixels(int u, int v, int count, const LabelRow& row) const {
    const D d;
    const D32 d32;
    const D16 d16;
    const auto lane = hn::Iota(d32, 0);
    const V columns = hn::ConvertTo(d, hn::Add(lane, hn::Set(d32, u)));
    const V one = DisparitiesAt(edge_.near.planes(), columns, static_cast<float>(v));
    const V other = DisparitiesAt(edge_.far.planes(), columns, static_cast<float>(v));
    const V less = hn::Min(one, other);  // planes may have crossed
    const V more = hn::Max(one, other);
    const auto is_apart = hn::Ge(hn::Sub(more, less), hn::Set(d, least_gap_px_));
    const auto chosen = hn::And(hn::RebindMask(d32, is_apart), hn::Lt(lane, hn::Set(d32, count)));
    const auto blend = [&](V disparities, int16_t* to) HWY_ATTR {
      const auto before = hn::PromoteTo(d32, hn::LoadU(d16, to));
      const auto now = hn::IfThenElse(chosen, NearestCounts(disparities), before);
      hn::StoreU(hn::DemoteTo(d16, now), d16, to);
    };
    blend(more, row.near);
    blend(less, row.far);
    const auto triangle = hn::LoadU(d32, row.triangle);
    hn::StoreU(hn::IfThenElse(chosen, hn::Set(d32, number_), triangle), d32, row.triangle);
  }

  const EdgeTriangle& edge_;
  int number_;
  float least_gap_px_;
  EdgeLabels& labels_;
};

}  // namespace

void PaintLabelsOnTarget(std::span<const EdgeTriangle> edges, std::span<const int> chosen,
                         std::span<const Plane> planes, float least_gap_px, const cv::Range& rows,
                         EdgeLabels& labels) {
  for (const int i : chosen) {
    const EdgeTriangle& edge = edges[static_cast<size_t>(i)];
    const LabelPaint paint(edge, i, least_gap_px, labels);
    ForEachRun(CornersOf(planes, edge.seeds), labels.near.cols, rows,
               [&](int v, int begin, int end) HWY_ATTR { paint.Run(v, begin, end); });
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace sprout::prior
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sprout::prior {

HWY_EXPORT(PaintLabelsOnTarget);

void PaintEdgeLabels(std::span<const EdgeTriangle> edges, std::span<const int> chosen,
                     std::span<const Plane> planes, float least_gap_px, const cv::Range& rows,
                     EdgeLabels& labels) {
  HWY_DYNAMIC_DISPATCH(PaintLabelsOnTarget)(edges, chosen, planes, least_gap_px, rows, labels);
}

}  // namespace sprout::prior
#endif  // HWY_ONCE
