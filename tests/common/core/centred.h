#pragma once

#include "common/core/rig.h"

namespace sprout {

/// A pair whose principal points are at half of the width and height, px.
constexpr RectifiedPair CentredPair(int width, int height, double focal_px,
                                    double baseline_m = 0.1) {
  return {.width = width,
          .height = height,
          .focal_px = focal_px,
          .cx = width / 2.0,
          .cy = height / 2.0,
          .cx_right = width / 2.0,
          .baseline_m = baseline_m};
}

/// Such a ToF camera, in the left camera's place.
inline TofCamera CentredTof(int width, int height, double focal_px) {
  return {.width = width,
          .height = height,
          .fx = focal_px,
          .fy = focal_px,
          .cx = width / 2.0,
          .cy = height / 2.0};
}

}  // namespace sprout
