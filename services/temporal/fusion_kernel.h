#pragma once

#include <array>
#include <cstdint>

#include "services/temporal/confidence_scale.h"
#include "services/temporal/view.h"

namespace sprout::temporal {

/// A pixel of a map without a disparity.
inline constexpr float kNone = -1e9F;

/// Where a pixel (u, v) of one left image with the shifted disparity ρ = d + cx_right − cx is in
/// another one, (T3): the homogeneous point H · (u, v, 1) + ρ t, whose third number w gives ρ/w.
struct PixelMotion {
  std::array<std::array<float, 3>, 3> h;
  std::array<float, 3> t;
};

/// What was known at the last frame, and how the camera moved since.
struct Memory {
  View<float> disparity;  ///< px, or kNone
  View<float> variance;   ///< px²
  View<uint8_t> grey;
  PixelMotion now_from_last;
  PixelMotion last_from_now;
  float offset_px;  ///< cx_right − cx
  float drift_px2;  ///< variance that a frame adds
};

/// Cells of 2×2 pixels: a coarse map of where the memory lies in the new image.
/// Moves the nearest disparity of every cell to the new image, (T3); where several meet in a cell,
/// the nearest is kept.
/// @param cells  row by row, (width + 1)/2 × (height + 1)/2 and one more on every side, all kNone.
void SplatCells(const Memory& memory, float* cells);

/// For the upper left pixel of every cell of a row: replaces the cell's disparity by the memory's,
/// where there is one, and gives the difference of its grey value from that of the last image.
/// @param differences  −1 where there is no disparity.
void LookUpCells(const Memory& memory, const View<uint8_t>& grey, int cell_row, float* cells,
                 float* differences);

/// How disparities are fused, (T7) to (T10).
struct FusionRule {
  float gate_sigmas, gate_min_px, gate_max_px, min_gain;
  float shared;  ///< share of a frame's variance that earlier frames cannot reduce, 0 to 1
};

/// What a row is fused from, and into.
struct FusionRow {
  int v;
  const float* cells;     ///< of this row, from LookUpCells()
  const float* growth;    ///< of the variance, of each cell, (T6); 0: the memory is dropped
  const int16_t* counts;  ///< the new disparity map
  const uint8_t* confidence;
  const ConfidenceScale* scale;
  float* fused;           ///< px, or kNone
  float* fused_variance;  ///< px²
  int16_t* fused_counts;  ///< the same disparity in counts
  uint8_t* fused_confidence;
};
void FuseRow(const Memory& memory, const FusionRule& rule, const FusionRow& row);

}  // namespace sprout::temporal
