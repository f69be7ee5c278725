#include "services/refine/refiner.h"

#include <cmath>
#include <string>
#include <utility>

#include "common/core/image.h"
#include "common/core/parallel.h"

namespace sprout {
namespace {

constexpr int kRadius = Refiner::kWindow / 2;
constexpr int kWindowPixels = Refiner::kWindow * Refiner::kWindow;

int Pixel(float position) { return static_cast<int>(std::lround(position)); }

// Whether the window around a pixel lies in the image. Compares before it converts, since a point
// close to the camera plane projects to anywhere.
bool WindowFits(float u, float v, cv::Size size) {
  return u > kRadius - 0.5f && u < static_cast<float>(size.width - kRadius) - 0.5f &&
         v > kRadius - 0.5f && v < static_cast<float>(size.height - kRadius) - 0.5f;
}

// Of the grey values in the window around a pixel.
int WindowSum(const cv::Mat1b& image, int u, int v) {
  int sum = 0;
  for (int y = v - kRadius; y <= v + kRadius; ++y) {
    const uint8_t* row = image[y] + u - kRadius;
    for (int x = 0; x < Refiner::kWindow; ++x) sum += row[x];
  }
  return sum;
}

}  // namespace

Refiner::Refiner(const RefineConfig& config) : config_(config) { RequireInRange(config, "refine"); }

Result<SeedSet> Refiner::Compute(const cv::Mat1b& left, const cv::Mat1b& right, const TofImage& tof,
                                 const TofProjector& projector, SeedSet memory) {
  const Rig& rig = projector.rig();
  const cv::Size size = rig.pair.size();
  if (left.size() != size || right.size() != size) {
    return Fail("images of " + SizeText(left.size()) + " and " + SizeText(right.size()) +
                ": allowed is the calibrated size " + SizeText(size));
  }
  SeedSet result{.seeds = std::move(memory.seeds)};
  // Projection of every ToF point to (u, u', v) (paper, II-A).
  points_ = projector.Project(tof, result.outside, std::move(points_));
  result.raw = static_cast<int32_t>(points_.size()) + result.outside;
  surface_.Set(rig, points_);
  KeepReliable(left, right, tof, result);
  KeepVisible(left, right, result);
  return result;
}

// Takes over the points that are reliable for themselves.
void Refiner::KeepReliable(const cv::Mat1b& left, const cv::Mat1b& right, const TofImage& tof,
                           SeedSet& result) {
  fates_.resize(points_.size());
  ForEachParallel(points_.size(),
                  [&](size_t i) { fates_[i] = FateOf(points_[i], left, right, tof); });
  kept_.clear();
  for (size_t i = 0; i < points_.size(); ++i) {
    switch (fates_[i]) {
      case Fate::kKept:
        kept_.push_back(points_[i]);
        break;
      case Fate::kOutside:
        ++result.outside;
        break;
      case Fate::kDark:
        ++result.dark;
        break;
      case Fate::kLoose:
        ++result.loose;
    }
  }
}

Refiner::Fate Refiner::FateOf(const ProjectedPoint& point, const cv::Mat1b& left,
                              const cv::Mat1b& right, const TofImage& tof) const {
  const Seed& seed = point.seed;
  if (!WindowFits(seed.u, seed.v, left.size()) || !WindowFits(seed.u_right, seed.v, left.size()) ||
      seed.disparity() < 0) {
    return Fate::kOutside;
  }
  // Rule 1 (paper, II-B): unreliable depth on very dark regions.
  if (WindowSum(left, Pixel(seed.u), Pixel(seed.v)) < kWindowPixels * config_.min_mean_grey() ||
      (!tof.amplitude.empty() &&
       !(tof.amplitude(point.tof_v, point.tof_u) >= config_.min_amplitude()))) {
    return Fate::kDark;
  }
  // Over a wide spacing a slant alone puts neighbours further off than the tolerance.
  constexpr double kSteepest = 0.22;  // px of disparity a pixel
  const double tolerance_px =
      std::max(config_.loose_tolerance_px(), kSteepest * surface_.spacing_px());
  const bool loose = config_.loose_tolerance_px() > 0 && surface_.IsLoose(point, tolerance_px) &&
                     !surface_.IsConfirmed(point, tolerance_px, left, right);
  return loose ? Fate::kLoose : Fate::kKept;
}

// Makes seeds of the kept points that no nearer surface makes doubtful.
void Refiner::KeepVisible(const cv::Mat1b& left, const cv::Mat1b& right, SeedSet& result) {
  std::vector<Seed>& seeds = result.seeds;
  seeds.clear();
  seeds.reserve(kept_.size());
  for (const ProjectedPoint& point : kept_) seeds.push_back(point.seed);
  // Rule 2 (paper, II-B): background that the ToF camera sees beside or behind a nearer surface.
  // What it drops still hides other points.
  const std::vector<uint8_t>& background =
      background_.Find(seeds, left.size(), config_.background_tolerance_px());
  const HiddenRule rule{.core = config_.hidden_core(),
                        .reach = config_.hidden_reach(),
                        .tolerance_px = config_.hidden_tolerance_px()};
  const std::vector<uint8_t>* hidden =
      rule.reach > 0 ? &surface_.FindHidden(kept_, left, right, rule) : nullptr;
  size_t next = 0;
  for (size_t i = 0; i < seeds.size(); ++i) {
    if (background[i] != 0) {
      ++result.background;
    } else if (hidden != nullptr && (*hidden)[i] != 0) {
      ++result.hidden;
    } else {
      seeds[next++] = seeds[i];
    }
  }
  seeds.resize(next);
}

}  // namespace sprout
