#include "services/refine/unwrapping/range_unwrapper.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/core/parallel.h"
#include "common/core/quantile.h"
#include "common/core/window_sums.h"

namespace sprout::refine {
namespace {

// Moravec's normalised cross-correlation of two windows, up to 1.
double Correlation(const cv::Mat1b& left, const cv::Mat1b& right, cv::Point at_left,
                   cv::Point at_right) {
  constexpr double kPixels =
      (2 * UnwrappingRules::kRadius + 1) * (2 * UnwrappingRules::kRadius + 1);
  const WindowSums sums = SumWindows<UnwrappingRules::kRadius>(left, right, at_left, at_right);
  const double covariance = sums.products - sums.left * (sums.right / kPixels);
  const double variances = sums.left_squares - sums.left * (sums.left / kPixels) +
                           sums.right_squares - sums.right * (sums.right / kPixels);
  return 2 * covariance / (variances + 2 * UnwrappingRules::kNoise * kPixels);
}

// Best of three columns, as a ToF point is not more exact; 0, as by chance, where nothing can be
// compared.
double Support(const cv::Mat1b& left, const cv::Mat1b& right, const Seed& seed) {
  if (!IsInside(seed.u, seed.v, left.size(), UnwrappingRules::kRadius) || seed.disparity() < 0)
    return 0;
  const int row = cvRound(seed.v);
  const cv::Point at_left(cvRound(seed.u), row);
  double best = 0;
  for (const double off : {-1, 0, 1}) {
    const double u_right = seed.u_right + off;
    if (!IsInside(u_right, seed.v, right.size(), UnwrappingRules::kRadius)) continue;
    best = std::max(best, Correlation(left, right, at_left, {cvRound(u_right), row}));
  }
  return best;
}

// Whatever a sensor says.
bool IsAmplitude(float amplitude) { return amplitude > 0 && std::isfinite(amplitude); }

// The same point one range farther along its ray.
ProjectedPoint Farther(const ProjectedPoint& point, double depth_m, double range_m, double beyond_m,
                       const TofProjector& projector) {
  const TofCamera& tof = projector.rig().tof;
  const Eigen::Vector3d in_tof =
      projector.ray(point.tof_u, point.tof_v) * (depth_m * (1 + beyond_m / range_m));
  const Eigen::Vector3d in_left =
      tof.left_from_tof_rotation * in_tof + tof.left_from_tof_translation_m;
  if (in_left.z() <= 0) return point;
  ProjectedPoint farther{point.tof_u, point.tof_v, ProjectToPair(projector.rig().pair, in_left)};
  farther.seed.tof_u = point.seed.tof_u;
  farther.seed.tof_v = point.seed.tof_v;
  return farther;
}

}  // namespace

int32_t RangeUnwrapper::Apply(const cv::Mat1b& left, const cv::Mat1b& right, const TofImage& tof,
                              const TofProjector& projector, double range_m,
                              std::vector<ProjectedPoint>& points) {
  ranges_m_.create(tof.depth_m.size());
  ranges_m_.setTo(std::numeric_limits<double>::quiet_NaN());
  preference_.create(tof.depth_m.size());
  albedo_.create(tof.depth_m.size());
  far_.resize(points.size());
  ForEachParallel(points.size(), [&](size_t i) {
    const ProjectedPoint& point = points[i];
    const cv::Point pixel(point.tof_u, point.tof_v);
    const double depth_m = tof.depth_m(pixel);
    ranges_m_(pixel) = depth_m * projector.ray(pixel.x, pixel.y).norm();
    const float amplitude = tof.amplitude.empty() ? 0 : tof.amplitude(pixel);
    albedo_(pixel) = IsAmplitude(amplitude)
                         ? static_cast<float>(amplitude * ranges_m_(pixel) * ranges_m_(pixel))
                         : 0;
    far_[i] = Farther(point, depth_m, ranges_m_(pixel), range_m, projector);
    preference_(pixel) =
        static_cast<float>(Support(left, right, far_[i].seed) - Support(left, right, point.seed));
  });
  FindMedianAlbedo(points);
  const TofCamera& camera = projector.rig().tof;
  FindSurfaces(UnwrappingRules::kSteepest * range_m / std::min(camera.fx, camera.fy));
  size_t kept = 0;
  for (size_t i = 0; i < points.size(); ++i) {
    const auto verdict = Verdict{verdicts_(points[i].tof_v, points[i].tof_u)};
    if (verdict == Verdict::kUnsure) continue;
    points[kept++] = verdict == Verdict::kFar ? far_[i] : points[i];
  }
  const auto taken = static_cast<int32_t>(points.size() - kept);
  points.resize(kept);
  return taken;
}

TofImage RangeUnwrapper::Unwrap(const cv::Mat1b& left, const cv::Mat1b& right, const TofImage& tof,
                                const TofProjector& projector, double range_m) {
  int behind = 0;
  std::vector<ProjectedPoint> points = projector.Project(tof, behind);
  Apply(left, right, tof, projector, range_m, points);
  TofImage unwrapped{.depth_m = tof.depth_m.clone(), .amplitude = tof.amplitude};
  for (int v = 0; v < tof.depth_m.rows; ++v) {
    for (int u = 0; u < tof.depth_m.cols; ++u) {
      if (std::isnan(ranges_m_(v, u))) continue;
      const auto verdict = Verdict{verdicts_(v, u)};
      float& depth_m = unwrapped.depth_m(v, u);
      if (verdict == Verdict::kFar) depth_m *= static_cast<float>(1 + range_m / ranges_m_(v, u));
      if (verdict == Verdict::kUnsure) depth_m = 0;
    }
  }
  return unwrapped;
}

void RangeUnwrapper::FindMedianAlbedo(std::span<const ProjectedPoint> points) {
  median_albedo_ = 0;
  if (points.empty()) return;
  albedos_.clear();
  for (const ProjectedPoint& point : points) {
    albedos_.push_back(albedo_(point.tof_v, point.tof_u));
  }
  median_albedo_ = Median(albedos_);
}

// Connects ToF pixels side by side, and judges what they make up.
void RangeUnwrapper::FindSurfaces(double step_m) {
  const cv::Rect image({}, ranges_m_.size());
  verdicts_.create(ranges_m_.size());
  seen_.create(ranges_m_.size());
  seen_.setTo(0);
  for (int v = 0; v < image.height; ++v) {
    for (int u = 0; u < image.width; ++u) {
      if (seen_(v, u) != 0 || std::isnan(ranges_m_(v, u))) continue;
      surface_.assign(1, {u, v});
      seen_(v, u) = 1;
      for (size_t i = 0; i < surface_.size(); ++i) {
        const cv::Point from = surface_[i];
        for (const cv::Point& step : {cv::Point(1, 0), {-1, 0}, {0, 1}, {0, -1}}) {
          const cv::Point to = from + step;
          if (!image.contains(to) || seen_(to) != 0) continue;
          if (!(std::abs(ranges_m_(to) - ranges_m_(from)) <= step_m)) continue;
          seen_(to) = 1;
          surface_.push_back(to);
        }
      }
      const Verdict verdict = Judge(surface_);
      for (const cv::Point& pixel : surface_) verdicts_(pixel) = static_cast<uint8_t>(verdict);
    }
  }
}

RangeUnwrapper::Verdict RangeUnwrapper::Judge(const std::vector<cv::Point>& surface) const {
  if (surface.size() < UnwrappingRules::kMinPoints) return Verdict::kNear;
  double preference = 0;
  double albedo = 0;
  for (const cv::Point& pixel : surface) {
    preference += double{preference_(pixel)};
    albedo += double{albedo_(pixel)};
  }
  const auto points = static_cast<double>(surface.size());
  if (preference > UnwrappingRules::kClearly * points) return Verdict::kFar;
  // Unless the images speak against it.
  if (preference > -UnwrappingRules::kUnclearly * points &&
      albedo < UnwrappingRules::kMinAlbedo * median_albedo_ * points) {
    return Verdict::kFar;
  }
  return preference > UnwrappingRules::kUnclearly * points ? Verdict::kUnsure : Verdict::kNear;
}

}  // namespace sprout::refine
