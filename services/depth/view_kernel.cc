// Compiled by Highway once for each instruction set; one of them is picked when the program runs.
// Plain loops over a row: the compiler makes vectors of them. Only +, −, ·, / and comparisons of
// single numbers, so all of them give the same bits.
#include "services/depth/view_kernel.h"

#include <algorithm>

#include "common/core/disparity_image.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "services/depth/view_kernel.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace sprout::depth {
namespace HWY_NAMESPACE {

constexpr float kInvalidCounts = DisparityImage::kInvalid;
// Replaces counts of 0 and less, which have no depth: the division stays finite. For any camera it
// is farther than 1000 km.
constexpr float kMinCounts = 1e-6F;

HWY_INLINE float Least(float a, float b) { return a < b ? a : b; }
HWY_INLINE float Most(float a, float b) { return a > b ? a : b; }

void ProjectOnTarget(const RowProjection& p, const int16_t* HWY_RESTRICT counts,
                     ProjectedRow& row) {
  const auto width = static_cast<int>(row.x.size());
  float* HWY_RESTRICT x = row.x.data();
  float* HWY_RESTRICT y = row.y.data();
  float* HWY_RESTRICT z = row.z.data();
  float* HWY_RESTRICT left = row.left_z.data();
  float* HWY_RESTRICT disparity = row.counts.data();
  // Copied to registers, since the compiler cannot know that the writes below do not change them.
  const auto [x0, y0, z0] = p.origin;
  const auto [start_x, start_y, start_z] = p.start;
  const auto [per_u_x, per_u_y, per_u_z] = p.per_u;
  const float focal_px = p.focal_px, cx = p.cx, cy = p.cy;
  const float metre_counts = p.metre_counts, shift = p.shift;
  for (int u = 0; u < width; ++u) {
    const auto column = static_cast<float>(u);
    const auto own = static_cast<float>(counts[u]);
    const float shifted = own + shift;
    const bool known = (own > kInvalidCounts) & (shifted > 0);
    const float left_z = metre_counts / Most(shifted, kMinCounts);
    const float view_z = z0 + left_z * (start_z + column * per_u_z);
    const float scale = focal_px / view_z;
    x[u] = scale * (x0 + left_z * (start_x + column * per_u_x)) + cx;
    y[u] = scale * (y0 + left_z * (start_y + column * per_u_y)) + cy;
    z[u] = (known & (view_z > 0)) ? view_z : 0.0F;
    left[u] = left_z;
    disparity[u] = own;
  }
  const auto pairs = [width](const float* HWY_RESTRICT values, float* HWY_RESTRICT least,
                             float* HWY_RESTRICT most) {
    for (int u = 0; u + 1 < width; ++u) {
      least[u] = Least(values[u], values[u + 1]);
      most[u] = Most(values[u], values[u + 1]);
    }
  };
  pairs(x, row.least_x.data(), row.most_x.data());
  pairs(y, row.least_y.data(), row.most_y.data());
  pairs(disparity, row.least_counts.data(), row.most_counts.data());
  float* HWY_RESTRICT least_z = row.least_z.data();
  float* HWY_RESTRICT sum_z = row.sum_z.data();
  for (int u = 0; u + 1 < width; ++u) {
    least_z[u] = Least(z[u], z[u + 1]);
    sum_z[u] = z[u] + z[u + 1];
  }
}

// Pairs of pixels of two rows. On the stack, so that the compiler knows that nothing aliases it.
struct Block {
  static constexpr int kSize = 256;

  alignas(64) float left[kSize], right[kSize], top[kSize], bottom[kSize];
  alignas(64) float depth[kSize];  // counts + 0.5
  alignas(64) int32_t surface[kSize];
  alignas(64) int32_t back[kSize];  // 1 where the view sees the surface from behind
};

HWY_INLINE void Bound(const ProjectedRow& upper, const ProjectedRow& lower, int first, int count,
                      Block& block) {
  const auto least = [=](const std::vector<float>& a, const std::vector<float>& b, float* to) {
    for (int i = 0; i < count; ++i) to[i] = Least(a.data()[first + i], b.data()[first + i]);
  };
  const auto most = [=](const std::vector<float>& a, const std::vector<float>& b, float* to) {
    for (int i = 0; i < count; ++i) to[i] = Most(a.data()[first + i], b.data()[first + i]);
  };
  least(upper.least_x, lower.least_x, block.left);
  most(upper.most_x, lower.most_x, block.right);
  least(upper.least_y, lower.least_y, block.top);
  most(upper.most_y, lower.most_y, block.bottom);
}

// NaN spans no surface, as comparisons with it are false.
HWY_INLINE void FindSurfaces(const ProjectedRow& upper, const ProjectedRow& lower,
                             const SpanRule& rule, int first, int count, Block& block) {
  const float* const least_above = upper.least_counts.data() + first;
  const float* const most_above = upper.most_counts.data() + first;
  const float* const least_below = lower.least_counts.data() + first;
  const float* const most_below = lower.most_counts.data() + first;
  const float* const z_above = upper.least_z.data() + first;
  const float* const z_below = lower.least_z.data() + first;
  const float surface_counts = rule.surface_counts, side_px = rule.side_px;
  for (int i = 0; i < count; ++i) {
    const float spread = Most(most_above[i], most_below[i]) - Least(least_above[i], least_below[i]);
    const int32_t flat =
        (spread <= surface_counts ? 1 : 0) & (Least(z_above[i], z_below[i]) > 0 ? 1 : 0);
    const int32_t small = (block.right[i] - block.left[i] <= side_px ? 1 : 0) &
                          (block.bottom[i] - block.top[i] <= side_px ? 1 : 0);
    block.surface[i] = flat & small;
  }
  const float* const x_above = upper.x.data() + first;
  const float* const y_above = upper.y.data() + first;
  const float* const x_below = lower.x.data() + first;
  const float* const y_below = lower.y.data() + first;
  for (int i = 0; i < count; ++i) {
    // Cross product of the diagonals from the upper left and the upper right corner: positive
    // unless the view sees the surface from behind.
    const float area = (x_below[i + 1] - x_above[i]) * (y_below[i] - y_above[i + 1]) -
                       (y_below[i + 1] - y_above[i]) * (x_below[i] - x_above[i + 1]);
    block.back[i] = block.surface[i] & (area > 0 ? 0 : 1);
  }
  const float* const sum_above = upper.sum_z.data() + first;
  const float* const sum_below = lower.sum_z.data() + first;
  const float quarter = 0.25F * rule.counts_per_m;
  for (int i = 0; i < count; ++i) {
    const float depth = (sum_above[i] + sum_below[i]) * quarter + 0.5F;
    const int32_t fills =
        block.surface[i] & ~block.back[i] & (depth >= 1 ? 1 : 0) & (depth < 65536 ? 1 : 0);
    block.depth[i] = fills != 0 ? depth : 0.0F;
  }
}

// The whole numbers from `low` to `high`, both included and clamped to 0 … `last`; none where there
// is no depth. The conversion to int rounds down, as nothing is negative.
HWY_INLINE void WholeNumbers(const float* HWY_RESTRICT low, const float* HWY_RESTRICT high,
                             const float* HWY_RESTRICT depth, float last, int count,
                             int32_t* HWY_RESTRICT begin, int32_t* HWY_RESTRICT end) {
  for (int i = 0; i < count; ++i) {
    const float from = Least(Most(low[i], 0), last + 1);
    const auto down = static_cast<int32_t>(from);
    begin[i] = down + (static_cast<float>(down) < from ? 1 : 0);
    const auto to = static_cast<int32_t>(Least(Most(high[i], -1) + 1, last + 1));
    end[i] = depth[i] > 0 ? to : 0;
  }
}

void SpansOnTarget(const ProjectedRow& upper, const ProjectedRow& lower, const SpanRule& rule,
                   Spans& spans) {
  const auto pairs = static_cast<int>(upper.x.size()) - 1;
  Block block;
  for (int first = 0; first < pairs; first += Block::kSize) {
    const int count = std::min(Block::kSize, pairs - first);
    Bound(upper, lower, first, count, block);
    FindSurfaces(upper, lower, rule, first, count, block);
    WholeNumbers(block.left, block.right, block.depth, rule.right, count,
                 spans.u_begin.data() + first, spans.u_end.data() + first);
    WholeNumbers(block.top, block.bottom, block.depth, rule.bottom, count,
                 spans.v_begin.data() + first, spans.v_end.data() + first);
    uint8_t* const surfaces = spans.surface.data() + first + 1;
    int32_t* const values = spans.value.data() + first;
    for (int i = 0; i < count; ++i) {
      surfaces[i] = static_cast<uint8_t>(block.surface[i] + 2 * block.back[i]);
    }
    for (int i = 0; i < count; ++i) values[i] = static_cast<int32_t>(Most(block.depth[i], 1)) - 1;
  }
}

void BordersOnTarget(const ProjectedRow& row, const std::vector<uint8_t>& above,
                     const std::vector<uint8_t>& below, std::vector<uint8_t>& borders) {
  const auto width = static_cast<int>(row.x.size());
  const float* HWY_RESTRICT z = row.z.data();
  const uint8_t* HWY_RESTRICT a = above.data();
  const uint8_t* HWY_RESTRICT b = below.data();
  uint8_t* HWY_RESTRICT border = borders.data();
  for (int u = 0; u < width; ++u) {
    const int all = a[u] & a[u + 1] & b[u] & b[u + 1];
    const int any = a[u] | a[u + 1] | b[u] | b[u + 1];
    border[u] = static_cast<uint8_t>((z[u] > 0 ? 1 : 0) & ~all & ~(any >> 1));
  }
}

void SmallerOnTarget(const uint16_t* HWY_RESTRICT other, size_t count,
                     uint16_t* HWY_RESTRICT kept) {
  for (size_t i = 0; i < count; ++i) kept[i] = other[i] < kept[i] ? other[i] : kept[i];
}

}  // namespace HWY_NAMESPACE
}  // namespace sprout::depth
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sprout::depth {

HWY_EXPORT(ProjectOnTarget);
HWY_EXPORT(SpansOnTarget);
HWY_EXPORT(BordersOnTarget);
HWY_EXPORT(SmallerOnTarget);

ProjectedRow::ProjectedRow(size_t width) {
  for (auto* values : {&x, &y, &z, &left_z, &counts, &least_x, &most_x, &least_y, &most_y, &least_z,
                       &sum_z, &least_counts, &most_counts}) {
    values->resize(width);
  }
}

Spans::Spans(size_t width) : surface(width + 1, 0) {
  for (auto* values : {&u_begin, &u_end, &v_begin, &v_end, &value}) values->resize(width);
}

void ProjectRow(const RowProjection& projection, const int16_t* counts, ProjectedRow& row) {
  HWY_DYNAMIC_DISPATCH(ProjectOnTarget)(projection, counts, row);
}

void FindSpans(const ProjectedRow& upper, const ProjectedRow& lower, const SpanRule& rule,
               Spans& spans) {
  HWY_DYNAMIC_DISPATCH(SpansOnTarget)(upper, lower, rule, spans);
}

void FindBorders(const ProjectedRow& row, const std::vector<uint8_t>& above,
                 const std::vector<uint8_t>& below, std::vector<uint8_t>& borders) {
  HWY_DYNAMIC_DISPATCH(BordersOnTarget)(row, above, below, borders);
}

void KeepSmaller(const uint16_t* other, size_t count, uint16_t* kept) {
  HWY_DYNAMIC_DISPATCH(SmallerOnTarget)(other, count, kept);
}

}  // namespace sprout::depth
#endif  // HWY_ONCE
