#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>

#include "common/core/checks.h"
#include "common/core/image.h"
#include "common/geometry/lens_fit.h"
#include "common/ros/from_ros.h"

namespace sprout {
namespace {

int32_t SideOf(uint32_t value) {
  return static_cast<int32_t>(std::min<uint32_t>(value, std::numeric_limits<int32_t>::max()));
}

template <size_t kSize>
bool AllFinite(const double (&values)[kSize]) {
  return std::ranges::all_of(values, [](double value) { return std::isfinite(value); });
}

// Largest error of a fitted lens, in pixels of the range image, which are several of the left
// image's.
constexpr double kWorstFitPx = 0.5;

// K and D as Brown's model has them, or comes near them; without coefficients every model is a
// pinhole.
Result<Lens> LensOf(const RosCameraInfo& ros) {
  const Lens lens{.width = SideOf(ros.width),
                  .height = SideOf(ros.height),
                  .fx = ros.k[0],
                  .fy = ros.k[4],
                  .cx = ros.k[2],
                  .cy = ros.k[5]};
  const std::string_view model = RosText(ros.distortion_model);
  const std::span d = RosSpan(ros.d);
  const bool is_pinhole = std::ranges::all_of(d, [](double value) { return value == 0; });
  const bool is_fisheye = model == "equidistant" || model == "fisheye";
  const bool is_opencvs = model.empty() || model == "plumb_bob" || model == "rational_polynomial";
  Checks checks;
  checks
      .Require(ros.k[0] > 0 && ros.k[4] > 0, "k[0]", ros.k[0],
               "a focal length > 0 (0: the camera is not calibrated)")
      .Require(AllFinite(ros.k), "k", "not finite", "finite numbers")
      .Require(std::ranges::all_of(d, [](double value) { return std::isfinite(value); }), "d",
               "not finite", "finite numbers")
      .Require(is_pinhole || is_fisheye || is_opencvs, "distortion_model", model.substr(0, 64),
               "plumb_bob, rational_polynomial or equidistant, or an image that is rectified")
      .Require(!is_fisheye || is_pinhole || d.size() == 4, "d", d.size(),
               "4 coefficients of equidistant")
      .Require(is_fisheye || d.size() <= 5 || d.size() == 8 || d.size() == 12 || d.size() == 14,
               "d", d.size(), "up to 5, 8, 12 or 14 coefficients");
  if (!checks.ok()) return checks.error();
  if (is_pinhole) return lens;
  const LensFit fit = FitBrown(lens, d, is_fisheye);
  checks.Require(
      fit.worst_px <= kWorstFitPx, "distortion_model", model.substr(0, 64),
      fmt::format("plumb_bob, or a lens like one of its: this one is up to {:.2g} px from "
                  "any, {} are allowed; or an image that is rectified",
                  fit.worst_px, kWorstFitPx));
  if (!checks.ok()) return checks.error();
  return fit.lens;
}

}  // namespace

Result<RosCamera> FromRosInfo(const RosCameraInfo& ros) {
  Checks checks;
  checks.Side("width", SideOf(ros.width))
      .Side("height", SideOf(ros.height))
      .Pixels("width × height", SideOf(ros.width), SideOf(ros.height))
      .Require(AllFinite(ros.r), "r", "not finite", "finite numbers")
      .Require(AllFinite(ros.p), "p", "not finite", "finite numbers")
      .Require(ros.p[0] > 0 && ros.p[5] > 0, "p[0]", ros.p[0],
               "a focal length > 0 (0: the camera is not calibrated)")
      .Require(ros.binning_x <= 1 && ros.binning_y <= 1, "binning_x", ros.binning_x, "0 and 1")
      .Require(ros.roi.x_offset == 0 && ros.roi.y_offset == 0, "roi.x_offset", ros.roi.x_offset,
               "the whole image");
  if (!checks.ok()) return checks.error();
  RosCamera camera{.width = SideOf(ros.width),
                   .height = SideOf(ros.height),
                   .lens = LensOf(ros),
                   .focal_px = ros.p[0],
                   .focal_v_px = ros.p[5],
                   .cx = ros.p[2],
                   .cy = ros.p[6],
                   .tx = ros.p[3]};
  camera.rectification = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(ros.r);
  const Eigen::Matrix3d& turn = camera.rectification;
  const bool is_turn = (turn * turn.transpose()).isIdentity(1e-6) && turn.determinant() > 0;
  checks.Require(is_turn, "r", "no rotation", "a rotation");
  if (!checks.ok()) return checks.error();
  return camera;
}

Result<RectifiedPair> PairOf(const RosCamera& left, const RosCamera& right) {
  constexpr double kSamePx = 1e-3;
  // How many rows off the upper and the lower edge may be when f_y stands for f_x: they belong to
  // points of the range sensor, which are not known better.
  constexpr double kMaxRowsOff = 0.5;
  const double from_middle = std::max(std::abs(left.cy), std::abs(left.height - 1 - left.cy));
  const double rows_off = std::abs(left.focal_v_px / left.focal_px - 1) * from_middle;
  Checks checks;
  checks
      .Require(left.size() == right.size(), "right width × height", SizeText(right.size()),
               "that of the left camera, " + SizeText(left.size()))
      .Require(rows_off <= kMaxRowsOff, "left p[5]", left.focal_v_px,
               fmt::format("p[0] = {:g}: square pixels", left.focal_px))
      .Require(std::abs(left.focal_px - right.focal_px) < kSamePx, "right p[0]", right.focal_px,
               "that of the left camera: a rectified pair")
      .Require(std::abs(left.focal_v_px - right.focal_v_px) < kSamePx, "right p[5]",
               right.focal_v_px, "that of the left camera: a rectified pair")
      .Require(std::abs(left.cy - right.cy) < kSamePx, "right p[6]", right.cy,
               "that of the left camera: a rectified pair")
      .Require(right.tx < left.tx, "right p[3]", right.tx,
               fmt::format("−f·b, below the left camera's, {:g}; are they swapped?", left.tx));
  if (!checks.ok()) return checks.error();
  const RectifiedPair pair{.width = left.width,
                           .height = left.height,
                           .focal_px = left.focal_px,
                           .cx = left.cx,
                           .cy = left.cy,
                           .cx_right = right.cx,
                           .baseline_m = (left.tx - right.tx) / left.focal_px};
  if (const Result<void> usable = CheckRig({.pair = pair, .tof = {}}); !usable) {
    return tl::unexpected(usable.error());
  }
  return pair;
}

}  // namespace sprout
