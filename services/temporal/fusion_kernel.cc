// Compiled by Highway once for each instruction set; one of them is picked when the program runs.
// Plain loops over blocks of a row: the compiler makes vectors of them. Only +, −, ·, / and √ on
// single numbers, so all of them give the same bits.
#include "services/temporal/fusion_kernel.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/core/disparity_image.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "services/temporal/fusion_kernel.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#ifndef SPROUT_SERVICES_TEMPORAL_FUSION_CONSTANTS_
#define SPROUT_SERVICES_TEMPORAL_FUSION_CONSTANTS_
namespace sprout::temporal {

inline constexpr int kBlock = 256;  // pixels whose numbers fit the first cache
inline constexpr float kHalfNone = kNone / 2;

// Disparities within this of each other lie on one surface: px, and a share of the disparity.
inline constexpr float kSurfacePx = 1;
inline constexpr float kSurfaceShare = 0.02F;
// Least weight of a pixel's neighbours on its surface, of 1.
inline constexpr float kLeastSupport = 0.25F;
// Farthest that the disparity found may be from the one that said where to look, px.
inline constexpr float kFarthestPx = 1.5F;
// Variance of a disparity that won against another one: times this, since one of them is wrong.
inline constexpr float kDisputed = 1.5F;
// Variances are kept within these, px²: a seventh of a pixel is what rounding and calibration leave.
inline constexpr float kLeastVariance = 0.02F;
inline constexpr float kLargestVariance = 16;
// Of a pixel without a disparity.
inline constexpr float kNoVariance = 1e6F;

}  // namespace sprout::temporal
#endif

HWY_BEFORE_NAMESPACE();
namespace sprout::temporal {
namespace HWY_NAMESPACE {

// One number of H · (u, v, 1) + ρ t, for the pixels of a row.
struct Line {
  Line(const PixelMotion& motion, size_t i, float v)
      : along(motion.h[i][0]),
        start(motion.h[i][1] * v + motion.h[i][2]),
        of_disparity(motion.t[i]) {}
  HWY_INLINE float At(float u, float rho) const { return along * u + start + of_disparity * rho; }

  float along, start, of_disparity;
};

HWY_INLINE float Third(const PixelMotion& motion, float u, float v, float rho) {
  return motion.h[2][0] * u + motion.h[2][1] * v + motion.h[2][2] + motion.t[2] * rho;
}

// Pixels of a row, and what the memory knows of them.
struct Block {
  int count = 0;
  alignas(64) float u[kBlock];         // columns
  alignas(64) float start[kBlock];     // disparity that says where to look, or kNone
  alignas(64) float last_u[kBlock];    // where that is in the last image
  alignas(64) float last_v[kBlock];
  alignas(64) float expected[kBlock];  // disparity there; far from all others where that is outside
  alignas(64) int32_t index[kBlock];   // of the pixel to the upper left of that place
  alignas(64) float around[4][kBlock];
  alignas(64) float variance[kBlock];
  alignas(64) float found[kBlock];     // disparity now, or kNone
};

// Where a pixel is in the last image if it has the disparity `start`.
HWY_INLINE void Aim(const Memory& memory, int v, Block& block) {
  const auto row = static_cast<float>(v);
  const Line x(memory.last_from_now, 0, row);
  const Line y(memory.last_from_now, 1, row);
  const Line w(memory.last_from_now, 2, row);
  const float offset = memory.offset_px;
  // The neighbours to the right and below must be inside.
  const float right = static_cast<float>(memory.disparity.width) - 1.001F;
  const float bottom = static_cast<float>(memory.disparity.height) - 1.001F;
  const auto stride = static_cast<int32_t>(memory.disparity.stride);
  for (int i = 0; i < block.count; ++i) {
    const float rho = block.start[i] + offset;
    const float scale = w.At(block.u[i], rho);
    const float inverse = 1 / scale;
    const float u = x.At(block.u[i], rho) * inverse;
    const float last_v = y.At(block.u[i], rho) * inverse;
    const bool inside = (block.start[i] > kHalfNone) & (scale > 0) & (u >= 0) & (u <= right) &
                        (last_v >= 0) & (last_v <= bottom);
    block.last_u[i] = inside ? u : 0;
    block.last_v[i] = inside ? last_v : 0;
    block.expected[i] = inside ? rho * inverse - offset : -kNone;
    block.index[i] =
        static_cast<int32_t>(block.last_v[i]) * stride + static_cast<int32_t>(block.last_u[i]);
  }
}

// A better `start`: the disparity of the nearest pixel there, where it lies on the same surface.
HWY_INLINE void Approach(const Memory& memory, Block& block) {
  const float* const disparity = memory.disparity.pixels;
  const auto stride = static_cast<int32_t>(memory.disparity.stride);
  for (int i = 0; i < block.count; ++i) {
    const auto u = static_cast<int32_t>(block.last_u[i] + 0.5F);
    const auto v = static_cast<int32_t>(block.last_v[i] + 0.5F);
    block.around[0][i] = disparity[v * stride + u];
  }
  for (int i = 0; i < block.count; ++i) {
    const float there = block.around[0][i];
    const float expected = block.expected[i];
    const bool same = std::abs(there - expected) <= kSurfacePx + kSurfaceShare * expected;
    const float rho = there + memory.offset_px;
    const float scale = Third(memory.now_from_last, block.last_u[i], block.last_v[i], rho);
    const float now = rho / scale - memory.offset_px;
    block.start[i] = same & (scale > 0) ? now : block.start[i];
  }
}

// (T4): the mean of the four neighbours that lie on the surface expected there, moved to now.
HWY_INLINE void Find(const Memory& memory, Block& block) {
  const float* const disparity = memory.disparity.pixels;
  const float* const variance = memory.variance.pixels;
  const auto stride = static_cast<int32_t>(memory.disparity.stride);
  const auto variance_stride = static_cast<int32_t>(memory.variance.stride);
  for (int i = 0; i < block.count; ++i) {
    const float* const at = disparity + block.index[i];
    block.around[0][i] = at[0];
    block.around[1][i] = at[1];
    block.around[2][i] = at[stride];
    block.around[3][i] = at[stride + 1];
  }
  for (int i = 0; i < block.count; ++i) {
    const auto u = static_cast<int32_t>(block.last_u[i] + 0.5F);
    const auto v = static_cast<int32_t>(block.last_v[i] + 0.5F);
    block.variance[i] = variance[v * variance_stride + u];
  }
  const float offset = memory.offset_px;
  const auto most = static_cast<float>(memory.disparity.width);
  for (int i = 0; i < block.count; ++i) {
    const float right =
        block.last_u[i] - static_cast<float>(static_cast<int32_t>(block.last_u[i]));
    const float below =
        block.last_v[i] - static_cast<float>(static_cast<int32_t>(block.last_v[i]));
    const float weights[4] = {(1 - right) * (1 - below), right * (1 - below), (1 - right) * below,
                              right * below};
    const float expected = block.expected[i];
    const float tolerance = kSurfacePx + kSurfaceShare * expected;
    float sum = 0;
    float support = 0;
    for (int k = 0; k < 4; ++k) {
      const float value = block.around[k][i];
      const float weight = std::abs(value - expected) <= tolerance ? weights[k] : 0;
      sum += weight * value;
      support += weight;
    }
    const float rho = sum / std::max(support, kLeastSupport) + offset;
    const float scale = Third(memory.now_from_last, block.last_u[i], block.last_v[i], rho);
    const float growth = 1 / scale;
    const float now = rho * growth - offset;
    const bool good = (support >= kLeastSupport) & (scale > 0) & (rho > 0) &
                      (std::abs(now - block.start[i]) <= kFarthestPx) & (now > -0.5F) &
                      (now < most);
    const float growth2 = growth * growth;
    block.found[i] = good ? now : kNone;
    block.variance[i] = block.variance[i] * (growth2 * growth2) + memory.drift_px2;
  }
}

void SplatOnTarget(const Memory& memory, float* cells) {
  const View<float>& map = memory.disparity;
  const int columns = (map.width + 1) / 2;
  const int rows = (map.height + 1) / 2;
  const PixelMotion& motion = memory.now_from_last;
  alignas(64) float column[kBlock], row[kBlock], moved[kBlock];
  for (int v = 0; v < rows; ++v) {
    const float* const above = map.Row(2 * v);
    const float* const below = map.Row(std::min(2 * v + 1, map.height - 1));
    const float middle = static_cast<float>(2 * v) + 0.5F;
    const Line x(motion, 0, middle), y(motion, 1, middle), w(motion, 2, middle);
    // Of an odd last column the neighbour is the pixel itself.
    for (int first = 0; first < columns; first += kBlock) {
      const int count = std::min(kBlock, columns - first);
      const int whole = std::min(count, map.width / 2 - first);
      for (int i = 0; i < count; ++i) moved[i] = kNone;
      for (int i = 0; i < whole; ++i) {
        const int u = 2 * (first + i);
        moved[i] = std::max(std::max(above[u], above[u + 1]), std::max(below[u], below[u + 1]));
      }
      if (whole < count) {
        moved[count - 1] = std::max(above[map.width - 1], below[map.width - 1]);
      }
      for (int i = 0; i < count; ++i) {
        const float u = static_cast<float>(2 * (first + i)) + 0.5F;
        const float rho = moved[i] + memory.offset_px;
        const float scale = w.At(u, rho);
        const float inverse = 1 / scale;
        const bool good = (rho > 0) & (scale > 0);
        // In cells; what is outside the image is outside all cells.
        column[i] = good ? (x.At(u, rho) * inverse - 0.5F) / 2 : kNone;
        row[i] = good ? (y.At(u, rho) * inverse - 0.5F) / 2 : kNone;
        moved[i] = rho * inverse - memory.offset_px;
      }
      for (int i = 0; i < count; ++i) {
        if (!(column[i] > -1 && row[i] > -1 && column[i] < static_cast<float>(columns) &&
              row[i] < static_cast<float>(rows))) {
          continue;
        }
        // The cells to all sides, so that a surface that comes nearer has no holes. Both are
        // greater than −1.
        const int left = static_cast<int>(column[i] + 1) - 1;
        const int top = static_cast<int>(row[i] + 1) - 1;
        for (int b = std::max(top, 0); b <= std::min(top + 1, rows - 1); ++b) {
          for (int a = std::max(left, 0); a <= std::min(left + 1, columns - 1); ++a) {
            float& cell = cells[static_cast<ptrdiff_t>(b) * columns + a];
            cell = std::max(cell, moved[i]);
          }
        }
      }
    }
  }
}

void LookUpOnTarget(const Memory& memory, const View<uint8_t>& grey, int cell_row, float* cells,
                    float* differences) {
  const int columns = (grey.width + 1) / 2;
  const uint8_t* const now = grey.Row(2 * cell_row);
  Block block;
  for (int first = 0; first < columns; first += kBlock) {
    block.count = std::min(kBlock, columns - first);
    for (int i = 0; i < block.count; ++i) {
      block.u[i] = static_cast<float>(2 * (first + i));
      block.start[i] = cells[first + i];
    }
    Aim(memory, 2 * cell_row, block);
    Approach(memory, block);
    Aim(memory, 2 * cell_row, block);
    Find(memory, block);
    for (int i = 0; i < block.count; ++i) {
      const auto u = static_cast<int32_t>(block.last_u[i]);
      const auto v = static_cast<int32_t>(block.last_v[i]);
      const float right = block.last_u[i] - static_cast<float>(u);
      const float below = block.last_v[i] - static_cast<float>(v);
      const uint8_t* const at = memory.grey.pixels + v * memory.grey.stride + u;
      const uint8_t* const next = at + memory.grey.stride;
      const float then = (1 - below) * ((1 - right) * at[0] + right * at[1]) +
                         below * ((1 - right) * next[0] + right * next[1]);
      const float difference = std::abs(static_cast<float>(now[2 * (first + i)]) - then);
      const bool known = block.found[i] > kHalfNone;
      differences[first + i] = known ? difference : -1;
      cells[first + i] = known ? block.found[i] : block.start[i];
    }
  }
}

// Again for pixels where nothing was found, from what the new map says: beside nearer things, which
// cells make wider.
HWY_INLINE void FindAgain(const Memory& memory, const int16_t* counts, int v, Block& block) {
  Block rest;
  int places[kBlock];
  for (int i = 0; i < block.count; ++i) {
    if (block.found[i] > kHalfNone || counts[i] == DisparityImage::kInvalid) continue;
    places[rest.count] = i;
    rest.u[rest.count] = block.u[i];
    rest.start[rest.count++] = static_cast<float>(counts[i]) / DisparityImage::kCountsPerPixel;
  }
  if (rest.count == 0) return;
  Aim(memory, v, rest);
  Find(memory, rest);
  for (int i = 0; i < rest.count; ++i) {
    block.found[places[i]] = rest.found[i];
    block.variance[places[i]] = rest.variance[i];
  }
}

void FuseOnTarget(const Memory& memory, const FusionRule& rule, const FusionRow& row) {
  Block block;
  alignas(64) float growth[kBlock], fresh[kBlock], fresh_variance[kBlock];
  for (int first = 0; first < memory.disparity.width; first += kBlock) {
    block.count = std::min(kBlock, memory.disparity.width - first);
    for (int i = 0; i < block.count; ++i) {
      const int cell = (first + i) / 2;
      block.u[i] = static_cast<float>(first + i);
      block.start[i] = row.cells[cell];
      growth[i] = row.growth[cell];
      const int16_t count = row.counts[first + i];
      const bool known = count != DisparityImage::kInvalid;
      fresh[i] = known ? static_cast<float>(count) / DisparityImage::kCountsPerPixel : kNone;
      fresh_variance[i] = known ? row.variances[row.confidence[first + i]] : kNoVariance;
    }
    Aim(memory, row.v, block);
    Find(memory, block);
    FindAgain(memory, row.counts + first, row.v, block);
    float* const fused = row.fused + first;
    float* const fused_variance = row.fused_variance + first;
    for (int i = 0; i < block.count; ++i) {
      const float d = block.found[i];
      const bool known = (d > kHalfNone) & (growth[i] > 0);
      const float v = block.variance[i] * growth[i];
      const float r = fresh_variance[i];
      const float difference = fresh[i] - d;
      const float gate = std::min(
          std::max(rule.gate_sigmas * std::sqrt(v + r), rule.gate_min_px), rule.gate_max_px);
      const float gain = std::max(v / (v + r), rule.min_gain);
      const bool agree = known & (std::abs(difference) < gate);
      const bool older = known & (v < r);  // is surer
      fused[i] = agree ? d + gain * difference : older ? d : fresh[i];
      const float variance = agree ? (1 - gain) * v : older ? kDisputed * v : r;
      fused_variance[i] = std::min(std::max(variance, kLeastVariance), kLargestVariance);
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace sprout::temporal
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sprout::temporal {

HWY_EXPORT(SplatOnTarget);
HWY_EXPORT(LookUpOnTarget);
HWY_EXPORT(FuseOnTarget);

void SplatCells(const Memory& memory, float* cells) {
  HWY_DYNAMIC_DISPATCH(SplatOnTarget)(memory, cells);
}

void LookUpCells(const Memory& memory, const View<uint8_t>& grey, int cell_row, float* cells,
                 float* differences) {
  HWY_DYNAMIC_DISPATCH(LookUpOnTarget)(memory, grey, cell_row, cells, differences);
}

void FuseRow(const Memory& memory, const FusionRule& rule, const FusionRow& row) {
  HWY_DYNAMIC_DISPATCH(FuseOnTarget)(memory, rule, row);
}

}  // namespace sprout::temporal
#endif  // HWY_ONCE
