#include "common/scenes/sr4000.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>

#include "common/core/quantile.h"
#include "common/geometry/lens.h"
#include "common/scenes/solid_texture.h"
#include "common/scenes/stray_light.h"

namespace sprout::scenes {
namespace {

constexpr int kWidth = 176;
constexpr int kHeight = 144;
constexpr double kUnambiguousM = 5;  // 30 MHz: the data sheet
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
  // Both cameras see the columns from aim_px on.
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
  if (config.multipath() > 0 || config.scatter() > 0) {
    for (int v = 0; v < kHeight; ++v) {
      for (int u = 0; u < kWidth; ++u) {
        directions_.push_back(DirectionOfPixel(camera.lens(), Eigen::Vector2d(u, v)).homogeneous());
      }
    }
  }
}

double Sr4000::NoiseM(double amplitude) const {
  const double reference = config_.median_amplitude();
  const double ambient = config_.ambient_amplitude();
  return config_.depth_noise_m() * reference / amplitude *
         std::sqrt((amplitude + ambient) / (reference + ambient));
}

// The unambiguous range. With wrapped_percent it is half way between the ranges on either side of
// that share of the returns.
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

double Sr4000::DepthM(const Footprint& footprint) const {
  return footprint.middle_m + config_.flying_pixels() * (footprint.mixed_m - footprint.middle_m);
}

double Sr4000::TurnM() const {
  return config_.ambiguity_range_m() > 0 ? config_.ambiguity_range_m() : kUnambiguousM;
}

// "A reduced amount of light comes out nearer" (Lindner and Kolb, "Calibration of the
// intensity-related distance error of the PMD TOF-camera", SPIE 6764, 2007), with a smooth step in
// the logarithm of the amplitude.
double Sr4000::AmplitudeErrorM(double amplitude) const {
  return config_.amplitude_error_m() * (amplitude / (amplitude + config_.median_amplitude()) - 0.5);
}

cv::Mat1d Sr4000::SceneErrorM(const std::vector<Footprint>& footprints,
                              std::span<const TofSamples> phase_images) const {
  const bool is_stray = config_.multipath() > 0 || config_.scatter() > 0;
  cv::Mat1d error_m(kHeight, kWidth, 0.0);
  if (is_stray) {
    LitView view{.depth_m = cv::Mat1d(kHeight, kWidth, kNoReturn),
                 .light = cv::Mat1d(kHeight, kWidth, 0.0),
                 .focal_px = calibrated_.fx,
                 .directions = directions_};
    for (int i = 0; i < kWidth * kHeight; ++i) {
      const Footprint& footprint = footprints[static_cast<size_t>(i)];
      if (!footprint.IsMostlyKnown() || footprint.light <= 0) continue;
      view.depth_m(i) = DepthM(footprint);
      view.light(i) = footprint.light;
    }
    error_m = StrayLightErrorM(view, {.multipath = config_.multipath(),
                                      .scatter = config_.scatter(),
                                      .unambiguous_range_m = TurnM()});
  }
  if (!phase_images.empty()) AddMotionErrorM(footprints, phase_images, error_m);
  return error_m;
}

// Signal k is A_k cos(φ_k − k 90°); each is of another moment (Lindner and Kolb, "Compensation of
// motion artifacts for time-of-flight cameras", Dyn3D 2009).
void Sr4000::AddMotionErrorM(const std::vector<Footprint>& footprints,
                             std::span<const TofSamples> phase_images, cv::Mat1d& error_m) const {
  assert(phase_images.size() == 4);
  std::array<std::vector<Footprint>, 4> moments;
  std::ranges::transform(phase_images, moments.begin(), [this](const TofSamples& samples) {
    return FootprintsOf(samples, config_.footprint_px());
  });
  for (int i = 0; i < kWidth * kHeight; ++i) {
    const auto index = static_cast<size_t>(i);
    if (footprints[index].light <= 0) continue;
    // Relative to the phase without motion.
    const double still = range_per_depth_(i) * DepthM(footprints[index]) / TurnM();
    std::array<Phasor, 4> signals;
    for (size_t k = 0; k < 4; ++k) {
      const Footprint& moment = moments[k][index];
      signals[k] = moment.light * UnitPhasor(range_per_depth_(i) * DepthM(moment) / TurnM());
    }
    const Phasor sum{signals[0].real() + signals[2].real(), signals[1].imag() + signals[3].imag()};
    error_m(i) += TurnsOf(sum * UnitPhasor(-still)) * TurnM();
  }
}

Sr4000Frame Sr4000::Measure(const TofSamples& samples, int64_t frame,
                            std::span<const TofSamples> phase_images) const {
  assert(samples.depth_m.size() == cv::Size(kWidth, kHeight) * TofSamples::kPerSide);
  const std::vector<Footprint> footprints = FootprintsOf(samples, config_.footprint_px());
  const double exposure = Exposure(footprints, config_.median_amplitude());
  const cv::Mat1d scene_error_m = SceneErrorM(footprints, phase_images);
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
      double depth_m = DepthM(footprint);
      if (config_.max_range_m() > 0 && depth_m * range_per_depth_(v, u) > config_.max_range_m()) {
        continue;
      }
      const double error_m = scene_error_m(v, u) + AmplitudeErrorM(amplitude);
      if (error_m != 0) depth_m += error_m / range_per_depth_(v, u);
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

}  // namespace sprout::scenes
