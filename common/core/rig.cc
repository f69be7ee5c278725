#include "common/core/rig.h"

#include <cstdio>

#include "common/core/digest.h"

namespace sprout {

std::string RigId(const Rig& rig) {
  // Hexadecimal floating point is exact and does not depend on byte order.
  std::string text;
  const auto append = [&text](double value) {
    char number[40];
    std::snprintf(number, sizeof number, "%a;", value + 0.0);  // −0 is equal to 0
    text += number;
  };
  const RectifiedPair& pair = rig.pair;
  for (double value : {double(pair.width), double(pair.height), pair.focal_px, pair.cx, pair.cy,
                       pair.cx_right, pair.baseline_m}) {
    append(value);
  }
  const TofCamera& tof = rig.tof;
  for (double value : {double(tof.width), double(tof.height), tof.fx, tof.fy, tof.cx, tof.cy}) {
    append(value);
  }
  for (double value : tof.distortion) append(value);
  for (double value : tof.left_from_tof_rotation.coeffs()) append(value);
  for (double value : tof.left_from_tof_translation_m) append(value);
  return Digest(text);
}

}  // namespace sprout
