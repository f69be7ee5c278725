#include "common/scenes/zone_sensor.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <vector>

#include "common/core/quantile.h"
#include "common/core/tof_image.h"
#include "common/scenes/solid_texture.h"

namespace sprout::scenes {
namespace {

// A target begins, for NEAREST, where this share of its light has come back. Assumed.
constexpr double kBeginning = 0.05;
// Targets with less than this many times the least signal are doubtful. Assumed.
constexpr double kDoubtfulSignal = 2;

struct Echo {
  double depth_m;
  double light;  // albedo / m²
};

// A target before the sensor measures it.
struct Peak {
  double light = 0;
  double depth_m = 0;   // that the sensor reports
  double spread_m = 0;  // standard deviation of its depths
};

// @param echoes  by depth.
Peak PeakOf(std::span<const Echo> echoes, ZonesConfig::Mode mode) {
  Peak peak;
  double weighted = 0;
  for (const Echo& echo : echoes) {
    peak.light += echo.light;
    weighted += echo.light * echo.depth_m;
  }
  if (peak.light <= 0) return peak;
  peak.depth_m = weighted / peak.light;
  if (mode == ZonesConfig::NEAREST) {
    double sum = 0;
    for (const Echo& echo : echoes) {
      sum += echo.light;
      if (sum < kBeginning * peak.light) continue;
      peak.depth_m = echo.depth_m;
      return peak;
    }
  }
  double squares = 0;
  for (const Echo& echo : echoes) {
    squares += echo.light * (echo.depth_m - peak.depth_m) * (echo.depth_m - peak.depth_m);
  }
  peak.spread_m = std::sqrt(squares / peak.light);
  return peak;
}

// The light of a zone, by depth; nothing when most of it is unknown.
std::vector<Echo> EchoesOf(const TofSamples& samples, const cv::Rect& zone) {
  std::vector<Echo> echoes;
  for (int y = zone.y; y < zone.br().y; ++y) {
    for (int x = zone.x; x < zone.br().x; ++x) {
      const double depth_m = samples.depth_m(y, x);
      if (!std::isfinite(depth_m)) continue;
      echoes.push_back({depth_m, samples.albedo(y, x) / (depth_m * depth_m)});
    }
  }
  if (2 * std::ssize(echoes) < zone.area()) return {};
  std::ranges::stable_sort(echoes, {}, &Echo::depth_m);
  return echoes;
}

std::vector<Peak> PeaksOf(std::span<const Echo> echoes, const ZonesConfig& config) {
  std::vector<Peak> peaks;
  size_t begin = 0;
  for (size_t i = 1; i <= echoes.size(); ++i) {
    if (i < echoes.size() && echoes[i].depth_m - echoes[i - 1].depth_m < config.separation_m()) {
      continue;
    }
    peaks.push_back(PeakOf(echoes.subspan(begin, i - begin), config.mode()));
    begin = i;
  }
  return peaks;
}

// Light of a zone in the middle of all zones that see anything.
double MedianLight(const std::vector<std::vector<Peak>>& zones) {
  std::vector<double> lights;
  for (const std::vector<Peak>& peaks : zones) {
    double light = 0;
    for (const Peak& peak : peaks) light += peak.light;
    if (light > 0) lights.push_back(light);
  }
  return lights.empty() ? 0 : Median(lights);
}

}  // namespace

ZoneSensor::ZoneSensor(const RectifiedPair& pair, const ZonesConfig& config, uint32_t seed)
    : config_(config), seed_(seed) {
  RequireInRange(config, "capture.zones");
  const double aim_px = kAimDisparityPerWidth * pair.width;
  const double aim_m = pair.DepthFromDisparity(aim_px + std::max(0.0, pair.cx - pair.cx_right));
  camera_.width = config.columns() * kPixelsPerZone;
  camera_.height = config.rows() * kPixelsPerZone;
  camera_.left_from_tof_translation_m = {pair.baseline_m / 2, -kAboveM, 0};
  camera_.fx = camera_.width * pair.focal_px / (config.view_margin() * pair.width);
  camera_.fy = camera_.height * pair.focal_px / (config.view_margin() * pair.height);
  // The middle of the left image at that depth is in the middle.
  const double across = ((pair.width - 1) / 2.0 - pair.cx) / pair.focal_px -
                        camera_.left_from_tof_translation_m.x() / aim_m;
  const double down = ((pair.height - 1) / 2.0 - pair.cy) / pair.focal_px -
                      camera_.left_from_tof_translation_m.y() / aim_m;
  camera_.cx = (camera_.width - 1) / 2.0 - camera_.fx * across;
  camera_.cy = (camera_.height - 1) / 2.0 - camera_.fy * down;
}

TofZones ZoneSensor::Measure(const TofSamples& samples, int64_t frame) const {
  constexpr int kSide = kPixelsPerZone * TofSamples::kPerSide;  // samples of a zone
  assert(samples.depth_m.size() == cv::Size(config_.columns(), config_.rows()) * kSide);
  TofZones zones{
      .columns = config_.columns(),
      .rows = config_.rows(),
      .targets_per_zone = config_.targets(),
      .mode = config_.mode() == ZonesConfig::NEAREST ? ZoneMode::kNearest : ZoneMode::kMean,
      .left_from_sensor = {camera_.left_from_tof_rotation, camera_.left_from_tof_translation_m},
      .views = {},
      .targets = {}};
  std::vector<std::vector<Peak>> all;
  for (int v = 0; v < zones.rows; ++v) {
    for (int u = 0; u < zones.columns; ++u) {
      const auto across = [&](int column) {
        return static_cast<float>((column * kPixelsPerZone - 0.5 - camera_.cx) / camera_.fx);
      };
      const auto down = [&](int row) {
        return static_cast<float>((row * kPixelsPerZone - 0.5 - camera_.cy) / camera_.fy);
      };
      zones.views.push_back({across(u), across(u + 1), down(v), down(v + 1)});
      all.push_back(PeaksOf(EchoesOf(samples, {u * kSide, v * kSide, kSide, kSide}), config_));
    }
  }
  const double reference = MedianLight(all);
  const uint64_t key = Scramble(Scramble(seed_) + static_cast<uint64_t>(frame));
  for (size_t zone = 0; zone < all.size(); ++zone) {
    std::vector<Peak>& peaks = all[zone];
    std::erase_if(peaks, [&](const Peak& peak) {
      return peak.light <= 0 || 100 * peak.light < config_.min_signal_percent() * reference;
    });
    if (zones.mode == ZoneMode::kMean) {
      std::ranges::stable_sort(peaks, std::ranges::greater(), &Peak::light);
    }
    peaks.resize(static_cast<size_t>(zones.targets_per_zone));
    for (const Peak& peak : peaks) {
      // Shot noise, as Sr4000's.
      const double noise_m = peak.light <= 0 ? 0
                                             : config_.depth_noise_percent() / 100 * peak.depth_m *
                                                   std::sqrt(reference / peak.light);
      const double depth_m =
          peak.depth_m + noise_m * NormalDeviate(Scramble(key + zones.targets.size()));
      ZoneTarget target;
      if (peak.light > 0 && IsReturn(static_cast<float>(depth_m))) {
        target = {
            .depth_m = static_cast<float>(depth_m),
            .sigma_m = std::max(1e-4F, static_cast<float>(std::sqrt(
                                           noise_m * noise_m + peak.spread_m * peak.spread_m))),
            .status = 100 * peak.light < kDoubtfulSignal * config_.min_signal_percent() * reference
                          ? TargetStatus::kDoubtful
                          : TargetStatus::kValid};
      }
      zones.targets.push_back(target);
    }
  }
  return zones;
}

}  // namespace sprout::scenes
