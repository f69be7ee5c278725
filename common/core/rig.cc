#include "common/core/rig.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>

#include "common/core/check_lens.h"
#include "common/core/digest.h"

namespace sprout {
namespace {

constexpr double kMaxDistanceM = 1000;
constexpr double kMinBaselineM = 1e-4;

void CheckFocalLength(Checks& checks, const std::string& field, double focal_px, double side_px) {
  checks.Positive(field.c_str(), focal_px)
      .Within(field, focal_px, 0.05 * side_px, 50 * side_px,
              "px (0.05 to 50 times the image's longest side)");
}

void CheckCentre(Checks& checks, const std::string& field, double centre_px, double side_px) {
  checks.Finite(field.c_str(), centre_px)
      .Within(field, centre_px, -10 * side_px, 10 * side_px,
              "px (10 times the image's longest side)");
}

// How far the distortion moves the image's farthest corner at most, in its distances from the
// principal point.
double LargestShift(const Lens& lens) {
  const auto [k1, k2, p1, p2, k3] = lens.distortion;
  const double x = std::max(std::abs(lens.cx), std::abs(lens.width - lens.cx)) / lens.fx;
  const double y = std::max(std::abs(lens.cy), std::abs(lens.height - lens.cy)) / lens.fy;
  const double r2 = x * x + y * y;
  const double radial = r2 * (std::abs(k1) + r2 * (std::abs(k2) + r2 * std::abs(k3)));
  return radial + 3 * std::sqrt(r2) * (std::abs(p1) + std::abs(p2));
}

}  // namespace

void CheckLens(Checks& checks, const std::string& prefix, const Lens& lens) {
  const auto field = [&](const char* of_lens) { return prefix + of_lens; };
  const double side_px = std::max(lens.width, lens.height);
  checks.Side(field("width").c_str(), lens.width)
      .Side(field("height").c_str(), lens.height)
      .Pixels((prefix + "width × " + prefix + "height").c_str(), lens.width, lens.height);
  CheckFocalLength(checks, field("fx"), lens.fx, side_px);
  CheckFocalLength(checks, field("fy"), lens.fy, side_px);
  CheckCentre(checks, field("cx"), lens.cx, side_px);
  CheckCentre(checks, field("cy"), lens.cy, side_px);
  for (double value : lens.distortion) checks.Finite(field("distortion").c_str(), value);
  if (!checks.ok()) return;
  checks.Within(field("distortion") + ": shift of the farthest corner", LargestShift(lens), 0, 10,
                "times its distance from the principal point");
}

void CheckDistance(Checks& checks, const std::string& field, const Eigen::Vector3d& metres) {
  for (double value : metres) {
    checks.Finite(field.c_str(), value).Within(field, value, -kMaxDistanceM, kMaxDistanceM, "m");
  }
}

std::string RigId(const Rig& rig) {
  // Hexadecimal floating point is exact and does not depend on byte order. The text of printf's
  // "%a", which would depend on the locale.
  std::string text;
  const auto append = [&text](double value) {
    char digits[40];
    const double positive_zero = value + 0.0;  // −0 is equal to 0
    const auto [end, error] = std::to_chars(std::begin(digits), std::end(digits),
                                            std::abs(positive_zero), std::chars_format::hex);
    text += std::signbit(positive_zero) ? "-0x" : "0x";
    text.append(digits, end);
    text += ';';
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
  const double norm = tof.left_from_tof_rotation.norm();
  Checks checks;
  const double side_px = std::max(pair.width, pair.height);
  checks.Side("width", pair.width)
      .Side("height", pair.height)
      .Pixels("width × height", pair.width, pair.height);
  CheckFocalLength(checks, "focal_px", pair.focal_px, side_px);
  CheckCentre(checks, "cx", pair.cx, side_px);
  CheckCentre(checks, "cy", pair.cy, side_px);
  CheckCentre(checks, "cx_right", pair.cx_right, side_px);
  checks.Positive("baseline_m", pair.baseline_m)
      .Within("baseline_m", pair.baseline_m, kMinBaselineM, kMaxDistanceM, "m");
  if (tof.width != 0 || tof.height != 0) {
    CheckLens(checks, "tof_", tof.lens());
  } else {  // no ToF camera; what stands for its lens is still copied and printed
    const double numbers[] = {tof.fx, tof.fy, tof.cx, tof.cy};
    constexpr const char* kFields[] = {"tof_fx", "tof_fy", "tof_cx", "tof_cy"};
    for (size_t i = 0; i < std::size(numbers); ++i) checks.Finite(kFields[i], numbers[i]);
    for (double value : tof.distortion) checks.Finite("tof_distortion", value);
  }
  checks.Require(std::abs(norm - 1) < 1e-6, "left_from_tof_rotation norm", norm,
                 "1 (a unit quaternion)");
  CheckDistance(checks, "left_from_tof_translation_m", tof.left_from_tof_translation_m);
  if (!checks.ok()) return checks.error();
  return {};
}

}  // namespace sprout
