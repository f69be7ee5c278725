#include "common/core/rig.h"

#include <cmath>
#include <cstdio>
#include <utility>

#include "common/core/checks.h"
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

Result<void> CheckRig(const Rig& rig) {
  const RectifiedPair& pair = rig.pair;
  const TofCamera& tof = rig.tof;
  const auto& q = tof.left_from_tof_rotation;
  const double norm = std::sqrt(q.w() * q.w() + q.x() * q.x() + q.y() * q.y() + q.z() * q.z());
  Checks checks;
  checks.Side("width", pair.width)
      .Side("height", pair.height)
      .Pixels("width × height", pair.width, pair.height)
      .Positive("focal_px", pair.focal_px)
      .Finite("cx", pair.cx)
      .Finite("cy", pair.cy)
      .Finite("cx_right", pair.cx_right)
      .Positive("baseline_m", pair.baseline_m)
      .SidesOrNone("tof_width", tof.width, "tof_height", tof.height)
      .Pixels("tof_width × tof_height", tof.width, tof.height)
      .Finite("tof_cx", tof.cx)
      .Finite("tof_cy", tof.cy)
      .Require(std::abs(norm - 1) < 1e-6, "left_from_tof_rotation norm", norm,
               "1 (a unit quaternion)");
  for (const auto& [field, focal_px] : {std::pair{"tof_fx", tof.fx}, {"tof_fy", tof.fy}}) {
    // A rig without a ToF camera has no lens either.
    tof.width > 0 ? checks.Positive(field, focal_px) : checks.Finite(field, focal_px);
  }
  for (double value : tof.distortion) checks.Finite("tof_distortion", value);
  for (double value : tof.left_from_tof_translation_m) {
    checks.Finite("left_from_tof_translation_m", value);
  }
  if (!checks.ok()) return checks.error();
  return {};
}

}  // namespace sprout
