#pragma once

#include "common/core/rig.h"

namespace sprout::scenes {

inline RectifiedPair SomePair() {
  return {.width = 640,
          .height = 480,
          .focal_px = 800,
          .cx = 319.5,
          .cy = 239.5,
          .cx_right = 330,
          .baseline_m = 0.12};
}

}  // namespace sprout::scenes
