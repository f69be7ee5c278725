#pragma once

#include "common/rig/raw_rig.h"

namespace sprout {

/// A rig as one screws it together: lenses that distort, a right camera that is turned by degrees
/// and stands a little too high, a ToF camera between the two with a biased range.
inline RawRig TiltedRig() {
  RawRig rig;
  rig.left = {.width = 640,
              .height = 480,
              .fx = 520,
              .fy = 521,
              .cx = 322,
              .cy = 238,
              .distortion = {-0.12, 0.03, 0.0005, -0.0008, 0.001}};
  rig.right = {.width = 640,
               .height = 480,
               .fx = 516,
               .fy = 515,
               .cx = 315,
               .cy = 246,
               .distortion = {-0.11, 0.02, -0.0006, 0.0004, 0.002}};
  rig.left_from_right.rotation = Eigen::Quaterniond(1, 0.012, -0.02, 0.015).normalized();
  rig.left_from_right.translation_m = {0.1, 0.004, -0.003};
  rig.tof = {.width = 176,
             .height = 144,
             .fx = 160,
             .fy = 161,
             .cx = 88,
             .cy = 71,
             .distortion = {-0.2, 0.05, 0.001, -0.001, 0}};
  rig.left_from_tof.rotation = Eigen::Quaterniond(1, -0.01, 0.006, 0.004).normalized();
  rig.left_from_tof.translation_m = {0.05, -0.03, 0.01};
  rig.range_scale = 1.01;
  rig.range_offset_m = -0.02;
  return rig;
}

}  // namespace sprout
