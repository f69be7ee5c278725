#include "services/datasets/sr4000.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <vector>

#include "common/core/quantile.h"
#include "common/geometry/lens.h"
#include "services/datasets/normal_deviate.h"
#include "services/datasets/sensor_place.h"
#include "services/datasets/solid_texture.h"

namespace sprout::datasets {
namespace {

constexpr int kWidth = 176;
constexpr int kHeight = 144;
constexpr float kNoReturn = std::numeric_limits<float>::quiet_NaN();

// Assembly tolerances: no camera is mounted, and no sensor glued, without any. Half angles of 0.17°
// up, 0.23° to the left and 0.5° about the axis; principal point a pixel off the centre.
const Eigen::Quaterniond kMounting = Eigen::Quaterniond(1, 0.0015, -0.002, 0.0045).normalized();
constexpr double kOffCentreX = 1.3;
constexpr double kOffCentreY = -0.9;

// A mild barrel lens, 6 px in the corners at the focal length of the real camera. With another
// focal length the coefficients change so that the distortion in pixels stays.
constexpr double kRealFocalPx = 220;  // 43.6° × 34.6°
constexpr std::array<double, 5> kDistortion = {-0.22, 0.08, 0.0006, -0.0004, -0.01};
constexpr std::array<int, 5> kDistortionPower = {2, 4, 1, 1, 6};  // of x, besides x itself

double Power(double base, int exponent) {
  double power = 1;
  for (int i = 0; i < exponent; ++i) power *= base;
  return power;
}

// The rotation that takes the optical axis to a direction, without any about the axis. From sums
// and roots alone: the digest of the calibration must be the same on every machine.
Eigen::Quaterniond AxisTo(const Eigen::Vector3d& direction) {
  const Eigen::Vector3d d = direction / direction.norm();
  return Eigen::Quaterniond(1 + d.z(), -d.y(), d.x(), 0).normalized();
}

TofCamera CalibratedCamera(const RectifiedPair& pair, const Sr4000Config& config) {
  TofCamera camera;
  camera.width = kWidth;
  camera.height = kHeight;
  const double fitted_px = std::min(kWidth / double(pair.width), kHeight / double(pair.height)) *
                           pair.focal_px / config.view_margin();
  camera.fx = camera.fy = config.focal_px() > 0 ? config.focal_px() : fitted_px;
  camera.cx = (kWidth - 1) / 2.0 + kOffCentreX;
  camera.cy = (kHeight - 1) / 2.0 + kOffCentreY;
  for (size_t i = 0; i < kDistortion.size(); ++i) {
    camera.distortion[i] = kDistortion[i] * Power(camera.fx / kRealFocalPx, kDistortionPower[i]);
  }
  camera.left_from_tof_translation_m = {pair.baseline_m / 2, -kAboveM, 0};
  const double aim_px = kAimDisparityPerWidth * pair.width;
  // Both see the columns from aim_px on.
  const Eigen::Vector3d aim_ray((pair.width - 1 + aim_px) / 2 - pair.cx,
                                (pair.height - 1) / 2.0 - pair.cy, pair.focal_px);
  // Where infinity has a positive disparity, the camera is aimed as if it had none.
  const double from_infinity_px = aim_px + std::max(0.0, pair.cx_right - pair.cx);
  const Eigen::Vector3d aim_in_left = pair.baseline_m / from_infinity_px * aim_ray;
  camera.left_from_tof_rotation =
      AxisTo(aim_in_left - camera.left_from_tof_translation_m) * kMounting;
  return camera;
}

// Turned about its own place so that what it sees lies `error_px` further right and down in the
// colour images than its calibration says.
TofCamera Turned(TofCamera camera, double error_px, double focal_px) {
  const double half = error_px / focal_px / std::sqrt(2.0) / 2;
  const Eigen::Quaterniond turn = Eigen::Quaterniond(1, -half, half, 0).normalized();
  camera.left_from_tof_rotation = turn * camera.left_from_tof_rotation;
  return camera;
}

// Takes away the returns with the lowest amplitude, exactly that share of them; of equal ones the
// first pixel's first.
void DropWeakest(double percent, TofImage& tof) {
  std::vector<int> returns;
  for (int i = 0; i < static_cast<int>(tof.depth_m.total()); ++i) {
    if (!std::isnan(tof.depth_m(i))) returns.push_back(i);
  }
  std::ranges::stable_sort(returns, {}, [&](int i) { return tof.amplitude(i); });
  returns.resize(static_cast<size_t>(std::llround(percent / 100 * double(returns.size()))));
  for (const int i : returns) tof.depth_m(i) = kNoReturn;
}

// Leaves the first pixel of each step of that length, along the rows and along the columns.
void KeepEvery(double step_px, TofImage& tof) {
  const auto is_first = [&](int i) {
    return std::floor(i / step_px) != std::floor((i - 1) / step_px);
  };
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      if (!is_first(u) || !is_first(v)) tof.depth_m(v, u) = kNoReturn;
    }
  }
}

// What one ToF pixel looks at.
struct Footprint {
  int known = 0;        // samples with a surface
  double light = 0;     // mean light that comes back, in the unit of albedo / m²
  double mixed_m = 0;   // depth of all light together
  double middle_m = 0;  // depth of the surface that fills most of the pixel
  double spread = 0;    // between the nearest and the farthest depth, a share of the nearest
  int samples = 0;      // known or not

  bool IsMostlyKnown() const { return 2 * known >= samples; }
};

// @param reach  beyond the pixel's own borders, samples.
Footprint FootprintOf(const TofSamples& samples, int tof_u, int tof_v, int reach) {
  constexpr int kSide = TofSamples::kPerSide;
  const cv::Rect own(tof_u * kSide, tof_v * kSide, kSide, kSide);
  const cv::Rect area = (own - cv::Point(reach, reach) + cv::Size(2 * reach, 2 * reach)) &
                        cv::Rect({0, 0}, samples.depth_m.size());
  std::vector<double> depths;
  depths.reserve(static_cast<size_t>(area.area()));
  Footprint footprint{.samples = area.area()};
  double weighted = 0;
  double unweighted = 0;
  for (int y = area.y; y < area.y + area.height; ++y) {
    for (int x = area.x; x < area.x + area.width; ++x) {
      const double depth_m = samples.depth_m(y, x);
      if (!std::isfinite(depth_m)) continue;
      const double light = samples.albedo(y, x) / (depth_m * depth_m);
      footprint.light += light;
      weighted += light * depth_m;
      unweighted += depth_m;
      depths.push_back(depth_m);
    }
  }
  if (depths.empty()) return footprint;
  footprint.known = static_cast<int>(depths.size());
  footprint.mixed_m =
      footprint.light > 0 ? weighted / footprint.light : unweighted / footprint.known;
  footprint.light /= footprint.known;
  footprint.middle_m = Median(depths);
  const auto [nearest, farthest] = std::ranges::minmax(depths);
  footprint.spread = farthest / nearest - 1;
  return footprint;
}

// Counts for each unit of light, so that half of the pixels lie above the wanted median.
double Exposure(const std::vector<Footprint>& footprints, double median_amplitude) {
  std::vector<double> lights;
  for (const Footprint& footprint : footprints) {
    if (footprint.light > 0) lights.push_back(footprint.light);
  }
  if (lights.empty()) return 0;
  return median_amplitude / Median(lights);
}

}  // namespace

Sr4000::Sr4000(const RectifiedPair& pair, const Sr4000Config& config, uint32_t seed)
    : Sr4000(CalibratedCamera(pair, config), config, seed) {
  if (config.calibration_error_px() > 0) {
    actual_ = Turned(calibrated_, config.calibration_error_px(), pair.focal_px);
  }
}

Sr4000::Sr4000(const TofCamera& camera, const Sr4000Config& config, uint32_t seed)
    : config_(config), seed_(seed), calibrated_(camera), actual_(camera) {
  RequireInRange(config, "capture.sr4000");
  assert(camera.width == kWidth && camera.height == kHeight);
  range_per_depth_ = RangePerDepth(camera.lens());
}

double Sr4000::NoiseM(double amplitude) const {
  const double reference = config_.median_amplitude();
  const double ambient = config_.ambient_amplitude();
  return config_.depth_noise_m() * reference / amplitude *
         std::sqrt((amplitude + ambient) / (reference + ambient));
}

// With wrapped_percent: half way between the ranges on either side of that share of the returns.
double Sr4000::AmbiguityM(const cv::Mat1f& depth_m) const {
  if (config_.wrapped_percent() <= 0) return config_.ambiguity_range_m();
  std::vector<double> ranges_m;
  for (int i = 0; i < static_cast<int>(depth_m.total()); ++i) {
    if (!std::isnan(depth_m(i))) ranges_m.push_back(depth_m(i) * range_per_depth_(i));
  }
  const auto kept = std::llround((1 - config_.wrapped_percent() / 100) * double(ranges_m.size()));
  if (kept < 1 || kept >= std::ssize(ranges_m)) return 0;
  std::ranges::sort(ranges_m);
  return (ranges_m[static_cast<size_t>(kept - 1)] + ranges_m[static_cast<size_t>(kept)]) / 2;
}

// The phase tells the range only modulo half the wavelength of the modulation.
void Sr4000::Wrap(double ambiguity_m, cv::Mat1f& depth_m) const {
  if (ambiguity_m <= 0) return;
  for (int i = 0; i < static_cast<int>(depth_m.total()); ++i) {
    if (std::isnan(depth_m(i))) continue;
    const double range_m = std::fmod(depth_m(i) * range_per_depth_(i), ambiguity_m);
    depth_m(i) = range_m > 0 ? static_cast<float>(range_m / range_per_depth_(i)) : kNoReturn;
  }
}

Sr4000Frame Sr4000::Measure(const TofSamples& samples, int64_t frame) const {
  assert(samples.depth_m.size() == cv::Size(kWidth, kHeight) * TofSamples::kPerSide);
  const auto reach =
      static_cast<int>(std::lround((config_.footprint_px() - 1) / 2 * TofSamples::kPerSide));
  std::vector<Footprint> footprints;
  footprints.reserve(size_t{kWidth} * kHeight);
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) footprints.push_back(FootprintOf(samples, u, v, reach));
  }
  const double exposure = Exposure(footprints, config_.median_amplitude());
  const uint64_t key = Scramble(Scramble(seed_) + static_cast<uint64_t>(frame));

  TofImage tof{.depth_m = cv::Mat1f(kHeight, kWidth, kNoReturn),
               .amplitude = cv::Mat1f(kHeight, kWidth, 0.f)};
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      const auto index = static_cast<size_t>(v * kWidth + u);
      const Footprint& footprint = footprints[index];
      const double amplitude = exposure * footprint.light;
      tof.amplitude(v, u) = static_cast<float>(amplitude);
      const bool is_mixed =
          config_.mixed_percent() > 0 && 100 * footprint.spread > config_.mixed_percent();
      if (!footprint.IsMostlyKnown() || is_mixed) continue;
      if (amplitude <= 0 || amplitude < config_.min_amplitude()) continue;
      const double depth_m =
          footprint.middle_m + config_.flying_pixels() * (footprint.mixed_m - footprint.middle_m);
      if (config_.max_range_m() > 0 && depth_m * range_per_depth_(v, u) > config_.max_range_m()) {
        continue;
      }
      const double noise_m = NoiseM(amplitude) * NormalDeviate(Scramble(key + index));
      if (depth_m + noise_m <= 0) continue;
      tof.depth_m(v, u) = static_cast<float>(depth_m + noise_m);
    }
  }
  const double ambiguity_m = AmbiguityM(tof.depth_m);
  Wrap(ambiguity_m, tof.depth_m);
  DropWeakest(config_.blind_percent(), tof);
  KeepEvery(config_.every_px(), tof);
  return {tof, ambiguity_m};
}

}  // namespace sprout::datasets
