#include "services/capture/sr4000.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <vector>

#include "services/capture/solid_texture.h"

namespace sprout {
namespace {

constexpr int kWidth = 176;
constexpr int kHeight = 144;

// The camera looks at the middle of what both colour cameras see at this disparity, a share of the
// image width: the middle of what stereo scenes have.
constexpr double kAimDisparityPerWidth = 0.08;
constexpr double kAboveM = 0.02;  // over the line between the colour cameras

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

// A normal deviate from a key: the sum of twelve uniform numbers less its mean (Irwin and Hall).
// Variance 1, no value beyond ±6, and no libm function that differs between machines.
double Normal(uint64_t key) {
  uint64_t sum = 0;
  for (uint64_t word = 0; word < 3; ++word) {
    const uint64_t bits = Scramble(key + word);
    for (int part = 0; part < 4; ++part) sum += bits >> (16 * part) & 0xffff;
  }
  return (static_cast<double>(sum) - 12 * 32767.5) / 65536;
}

// What one ToF pixel looks at.
struct Footprint {
  int known = 0;        // samples with a surface
  double light = 0;     // mean light that comes back, in the unit of albedo / m²
  double mixed_m = 0;   // depth of all light together
  double middle_m = 0;  // depth of the surface that fills most of the pixel
};

Footprint FootprintOf(const TofSamples& samples, int tof_u, int tof_v) {
  constexpr int kSide = TofSamples::kPerSide;
  std::array<double, size_t{kSide} * kSide> depths;
  Footprint footprint;
  double weighted = 0;
  double unweighted = 0;
  for (int y = tof_v * kSide; y < (tof_v + 1) * kSide; ++y) {
    for (int x = tof_u * kSide; x < (tof_u + 1) * kSide; ++x) {
      const double depth_m = samples.depth_m(y, x);
      if (!std::isfinite(depth_m)) continue;
      const double light = samples.albedo(y, x) / (depth_m * depth_m);
      footprint.light += light;
      weighted += light * depth_m;
      unweighted += depth_m;
      depths[static_cast<size_t>(footprint.known++)] = depth_m;
    }
  }
  if (footprint.known == 0) return footprint;
  footprint.mixed_m =
      footprint.light > 0 ? weighted / footprint.light : unweighted / footprint.known;
  footprint.light /= footprint.known;
  const auto middle = depths.begin() + footprint.known / 2;
  std::nth_element(depths.begin(), middle, depths.begin() + footprint.known);
  footprint.middle_m = *middle;
  return footprint;
}

// Counts for each unit of light, so that half of the pixels lie above the wanted median.
double Exposure(const std::vector<Footprint>& footprints, double median_amplitude) {
  std::vector<double> lights;
  for (const Footprint& footprint : footprints) {
    if (footprint.light > 0) lights.push_back(footprint.light);
  }
  if (lights.empty()) return 0;
  const auto middle = lights.begin() + static_cast<std::ptrdiff_t>(lights.size() / 2);
  std::nth_element(lights.begin(), middle, lights.end());
  return median_amplitude / *middle;
}

}  // namespace

Sr4000::Sr4000(const RectifiedPair& pair, const Sr4000Config& config, uint32_t seed)
    : config_(config), seed_(seed) {
  RequireInRange(config, "capture.sr4000");
  calibrated_ = CalibratedCamera(pair, config);
  actual_ = config.calibration_error_px() > 0
                ? Turned(calibrated_, config.calibration_error_px(), pair.focal_px)
                : calibrated_;
}

double Sr4000::NoiseM(double amplitude) const {
  const double reference = config_.median_amplitude();
  const double ambient = config_.ambient_amplitude();
  return config_.depth_noise_m() * reference / amplitude *
         std::sqrt((amplitude + ambient) / (reference + ambient));
}

TofImage Sr4000::Measure(const TofSamples& samples, int64_t frame) const {
  assert(samples.depth_m.size() == cv::Size(kWidth, kHeight) * TofSamples::kPerSide);
  std::vector<Footprint> footprints;
  footprints.reserve(size_t{kWidth} * kHeight);
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) footprints.push_back(FootprintOf(samples, u, v));
  }
  const double exposure = Exposure(footprints, config_.median_amplitude());
  const uint64_t key = Scramble(Scramble(seed_) + static_cast<uint64_t>(frame));

  TofImage tof{.depth_m = cv::Mat1f(kHeight, kWidth, std::numeric_limits<float>::quiet_NaN()),
               .amplitude = cv::Mat1f(kHeight, kWidth, 0.f)};
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      const auto index = static_cast<size_t>(v * kWidth + u);
      const Footprint& footprint = footprints[index];
      const double amplitude = exposure * footprint.light;
      tof.amplitude(v, u) = static_cast<float>(amplitude);
      if (2 * footprint.known < TofSamples::kPerSide * TofSamples::kPerSide) continue;
      if (amplitude <= 0 || amplitude < config_.min_amplitude()) continue;
      const double depth_m =
          footprint.middle_m + config_.flying_pixels() * (footprint.mixed_m - footprint.middle_m);
      const double noise_m = NoiseM(amplitude) * Normal(Scramble(key + index));
      if (depth_m + noise_m <= 0) continue;
      tof.depth_m(v, u) = static_cast<float>(depth_m + noise_m);
    }
  }
  return tof;
}

}  // namespace sprout
