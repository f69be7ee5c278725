// Compiled by Highway once for each instruction set; one of them is picked when the program runs.
// Plain loops over blocks of a row: the compiler makes vectors of them. Only +, −, ·, / and √ on
// single numbers, so all of them give the same bits.
#include "services/temporal/fusion_kernel.h"

#include <algorithm>
#include <cmath>

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

// Disparities within this of each other lie on one surface: px, and a share of ρ.
inline constexpr float kSurfacePx = 1;
inline constexpr float kSurfaceShare = 0.02F;
// Least weight of a pixel's neighbours on its surface, of 1.
inline constexpr float kMinSupport = 0.25F;
// Largest difference of the disparity found from the one that said where to look, px.
inline constexpr float kMaxCorrectionPx = 1.5F;
// Factor by which the variance of a disparity that the new map lacks grows every frame.
inline constexpr float kAgeing = 1.5F;
// Fused variances are kept within these, px²: rounding and calibration leave errors of a seventh of
// a pixel. Where the new map has no disparity, the memory is dropped above the largest.
inline constexpr float kMinVariance = 0.02F;
inline constexpr float kMaxVariance = 16;
// Variance of a pixel without a disparity.
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
  alignas(64) float u[kBlock];       // columns
  alignas(64) float start[kBlock];   // disparity that says where to look, or kNone
  alignas(64) float last_u[kBlock];  // where that is in the last image
  alignas(64) float last_v[kBlock];
  alignas(64) float expected[kBlock];  // disparity expected there; −kNone where that is outside
  alignas(64) int32_t index[kBlock];   // of the pixel at or to the upper left of that place
  alignas(64) float around[4][kBlock];
  alignas(64) float variance[kBlock];
  alignas(64) float found[kBlock];  // disparity now, or kNone
};

// Where a pixel is in the last image if it has the disparity `start`.
HWY_INLINE void Aim(const Memory& memory, int v, Block& block) {
  const auto row = static_cast<float>(v);
  const Line x(memory.last_from_now, 0, row);
  const Line y(memory.last_from_now, 1, row);
  const Line w(memory.last_from_now, 2, row);
  const float offset = memory.offset_px;
  // The right and lower neighbours have to be inside, too.
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

// Replaces `start` by the disparity of the nearest pixel there, if it lies on the same surface.
HWY_INLINE void RefineStart(const Memory& memory, Block& block) {
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
    const float tolerance = kSurfacePx + kSurfaceShare * (expected + memory.offset_px);
    const bool same = std::abs(there - expected) <= tolerance;
    const float rho = there + memory.offset_px;
    const float scale = Third(memory.now_from_last, block.last_u[i], block.last_v[i], rho);
    const float now = rho / scale - memory.offset_px;
    block.start[i] = same & (scale > 0) ? now : block.start[i];
  }
}

// (T4): moves the mean of those of the four neighbours that lie on the expected surface.
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
  const float most = std::min(static_cast<float>(memory.disparity.width),
                              static_cast<float>(DisparityImage::kMaxPx));
  for (int i = 0; i < block.count; ++i) {
    const float right = block.last_u[i] - static_cast<float>(static_cast<int32_t>(block.last_u[i]));
    const float below = block.last_v[i] - static_cast<float>(static_cast<int32_t>(block.last_v[i]));
    const float weights[4] = {(1 - right) * (1 - below), right * (1 - below), (1 - right) * below,
                              right * below};
    const float expected = block.expected[i];
    const float tolerance = kSurfacePx + kSurfaceShare * (expected + offset);
    float sum = 0;
    float support = 0;
    for (int k = 0; k < 4; ++k) {
      const float value = block.around[k][i];
      const float weight = std::abs(value - expected) <= tolerance ? weights[k] : 0;
      sum += weight * value;
      support += weight;
    }
    const float rho = sum / std::max(support, kMinSupport) + offset;
    const float scale = Third(memory.now_from_last, block.last_u[i], block.last_v[i], rho);
    const float growth = 1 / scale;
    const float now = rho * growth - offset;
    const bool good = (support >= kMinSupport) & (scale > 0) & (rho > 0) &
                      (std::abs(now - block.start[i]) <= kMaxCorrectionPx) & (std::abs(now) < most);
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
    const float* const first_row = map.Row(2 * v);
    const float* const second_row = map.Row(std::min(2 * v + 1, map.height - 1));
    const float middle = static_cast<float>(2 * v) + 0.5F;
    const Line x(motion, 0, middle), y(motion, 1, middle), w(motion, 2, middle);
    // A last column without a partner is a cell of its own.
    for (int first = 0; first < columns; first += kBlock) {
      const int count = std::min(kBlock, columns - first);
      const int whole = std::min(count, map.width / 2 - first);
      for (int i = 0; i < count; ++i) moved[i] = kNone;
      for (int i = 0; i < whole; ++i) {
        const int u = 2 * (first + i);
        moved[i] = std::max(std::max(first_row[u], first_row[u + 1]),
                            std::max(second_row[u], second_row[u + 1]));
      }
      if (whole < count) {
        moved[count - 1] = std::max(first_row[map.width - 1], second_row[map.width - 1]);
      }
      for (int i = 0; i < count; ++i) {
        const float u = static_cast<float>(2 * (first + i)) + 0.5F;
        const float rho = moved[i] + memory.offset_px;
        const float scale = w.At(u, rho);
        const float inverse = 1 / scale;
        const bool good = (rho > 0) & (scale > 0);
        // Positions in cells; what is outside the image is outside all cells.
        column[i] = good ? (x.At(u, rho) * inverse - 0.5F) / 2 : kNone;
        row[i] = good ? (y.At(u, rho) * inverse - 0.5F) / 2 : kNone;
        moved[i] = rho * inverse - memory.offset_px;
      }
      for (int i = 0; i < count; ++i) {
        if (!(column[i] > -1 && row[i] > -1 && column[i] < static_cast<float>(columns) &&
              row[i] < static_cast<float>(rows))) {
          continue;
        }
        // All four cells around, so that a surface that comes nearer has no holes. Both numbers are
        // above −1, and the cells have a border.
        float* const above = cells + static_cast<ptrdiff_t>(row[i] + 1) * (columns + 2) +
                             static_cast<ptrdiff_t>(column[i] + 1);
        float* const below = above + columns + 2;
        const float d = moved[i];
        above[0] = std::max(above[0], d);
        above[1] = std::max(above[1], d);
        below[0] = std::max(below[0], d);
        below[1] = std::max(below[1], d);
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
    RefineStart(memory, block);
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

// Where nothing was found, looks again at the place that the new map's disparity points to. This is
// so beside near things, which cells make wider.
HWY_INLINE void FindFromNewMap(const Memory& memory, const int16_t* counts, int v, Block& block) {
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

// The new measurements of a block.
struct Fresh {
  alignas(64) float growth[kBlock];
  alignas(64) float disparity[kBlock];
  alignas(64) float variance[kBlock];
  alignas(64) float disputed[kBlock];  // the memory's variance where it disagrees, else 0
  alignas(64) float least[kBlock];     // smallest variance that is published, (T10)
};

HWY_INLINE void Load(const FusionRow& row, int first, Block& block, Fresh& fresh) {
  // Blocks begin at whole cells; the last cell may have one pixel more than the row.
  const float* const cells = row.cells + first / 2;
  const float* const growth = row.growth + first / 2;
  for (int i = 0; i < (block.count + 1) / 2; ++i) {
    block.start[2 * i] = block.start[2 * i + 1] = cells[i];
    fresh.growth[2 * i] = fresh.growth[2 * i + 1] = growth[i];
  }
  const int16_t* const counts = row.counts + first;
  const uint8_t* const confidence = row.confidence + first;
  const float* const variances = row.scale->variances().data();
  for (int i = 0; i < block.count; ++i) fresh.variance[i] = variances[confidence[i]];
  for (int i = 0; i < block.count; ++i) {
    block.u[i] = static_cast<float>(first + i);
    const bool known = counts[i] != DisparityImage::kInvalid;
    const float px = static_cast<float>(counts[i]) / DisparityImage::kCountsPerPixel;
    fresh.disparity[i] = known ? px : kNone;
    fresh.variance[i] = known ? fresh.variance[i] : kNoVariance;
  }
}

// Fuses by (T7) and (T8), in place: `found` and `variance` become the result.
HWY_INLINE void Fuse(FusionRule rule, Fresh& fresh, Block& block) {
  for (int i = 0; i < block.count; ++i) {
    const float d = block.found[i];
    const float v = block.variance[i] * fresh.growth[i];
    const float r = fresh.variance[i];
    const bool is_new = fresh.disparity[i] > kHalfNone;
    const bool lasts = is_new | (kAgeing * v <= kMaxVariance);
    const bool known = (d > kHalfNone) & (fresh.growth[i] > 0) & lasts;
    const float difference = fresh.disparity[i] - d;
    const float sigmas = rule.gate_sigmas * std::sqrt(v + r);
    const float gate = std::min(std::max(sigmas, rule.gate_min_px), rule.gate_max_px);
    const float gain = std::max(v / (v + r), rule.min_gain);
    const bool agree = known & (std::abs(difference) < gate);
    const bool older = known & (v < r);  // the memory is surer
    const float chosen = older ? d : fresh.disparity[i];
    const float variance = older ? kAgeing * v : r;
    block.found[i] = agree ? d + gain * difference : chosen;
    block.variance[i] = agree ? (1 - gain) * v : variance;
    fresh.disputed[i] = known & is_new & !agree ? v : 0;
    const float share = known ? rule.shared : 1;
    fresh.least[i] = is_new ? share * r : 0;
  }
}

// Writes the result with its confidence, (T9) and (T10).
HWY_INLINE void Store(const FusionRow& row, int first, Fresh& fresh, Block& block) {
  std::copy_n(block.found, block.count, row.fused + first);
  alignas(64) int32_t counts[kBlock];
  for (int i = 0; i < block.count; ++i) {
    const bool known = block.found[i] > kHalfNone;
    // Rounds half up: the conversion cuts off, and the number is shifted above 0.
    constexpr float kUp = -DisparityImage::kInvalid;
    const float up = (known ? block.found[i] : 0) * DisparityImage::kCountsPerPixel + (kUp + 0.5F);
    const int32_t count = static_cast<int32_t>(up) + DisparityImage::kInvalid;
    counts[i] = known ? count : DisparityImage::kInvalid;
  }
  int16_t* const to = row.fused_counts + first;
  for (int i = 0; i < block.count; ++i) to[i] = static_cast<int16_t>(counts[i]);
  uint8_t* const confidence = row.fused_confidence + first;
  for (int i = 0; i < block.count; ++i) {
    if (const float v = fresh.disputed[i]; v > 0) {
      const float r = fresh.variance[i];
      block.variance[i] = row.scale->VarianceOfSurer(v, r);
      fresh.least[i] = row.scale->VarianceOfSurer(std::max(v, fresh.least[i]), r);
    }
    const float variance = std::max(block.variance[i], kMinVariance);
    row.fused_variance[first + i] = std::min(variance, kMaxVariance);
    const float told = std::max(variance, fresh.least[i]);
    confidence[i] = block.found[i] > kHalfNone ? row.scale->ConfidenceOf(told) : uint8_t{0};
  }
}

void FuseOnTarget(const Memory& memory, const FusionRule& rule, const FusionRow& row) {
  Block block;
  Fresh fresh;
  for (int first = 0; first < memory.disparity.width; first += kBlock) {
    block.count = std::min(kBlock, memory.disparity.width - first);
    Load(row, first, block, fresh);
    Aim(memory, row.v, block);
    Find(memory, block);
    FindFromNewMap(memory, row.counts + first, row.v, block);
    Fuse(rule, fresh, block);
    Store(row, first, fresh, block);
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
