#include "services/tools/evaluate/seed_quality.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <utility>
#include <vector>

#include "services/refine/refiner.h"

namespace sprout::evaluate {
namespace {

double Percent(int64_t part, int64_t whole) {
  if (whole == 0) return std::numeric_limits<double>::quiet_NaN();
  return 100.0 * static_cast<double>(part) / static_cast<double>(whole);
}

// Compared before it is converted: points beside the cameras project to anywhere.
bool InImage(const Seed& seed, cv::Size size) {
  return seed.u > -0.5F && seed.u < static_cast<float>(size.width) - 0.5F && seed.v > -0.5F &&
         seed.v < static_cast<float>(size.height) - 0.5F;
}

std::vector<Seed> ProjectAll(const Scene& scene) {
  int behind = 0;
  std::vector<Seed> seeds;
  for (const ProjectedPoint& point : scene.projector.Project(scene.frame.tof, behind)) {
    seeds.push_back(point.seed);
  }
  return seeds;
}

enum class Verdict { kGood, kWrong, kUnknown };

Verdict Judge(const Seed& seed, const Scene& scene) {
  if (!InImage(seed, scene.size())) return Verdict::kUnknown;
  const cv::Point pixel(cvRound(seed.u), cvRound(seed.v));
  const double error = std::abs(double{seed.disparity()} - scene.frame.truth.left(pixel));
  if (error > kWrongSeedPx || scene.occluded(pixel) != 0) return Verdict::kWrong;
  return scene.nonoccluded(pixel) != 0 ? Verdict::kGood : Verdict::kUnknown;
}

}  // namespace

SeedCounts CountSeeds(std::span<const Seed> seeds, const Scene& scene) {
  SeedCounts counts;
  for (const Seed& seed : seeds) {
    const Verdict verdict = Judge(seed, scene);
    counts.good += verdict == Verdict::kGood;
    counts.wrong += verdict == Verdict::kWrong;
  }
  return counts;
}

int64_t CountGoodLost(std::span<const Seed> points, std::span<const Seed> kept,
                      const Scene& scene) {
  std::set<std::pair<int16_t, int16_t>> kept_pixels;
  for (const Seed& seed : kept) {
    if (seed.origin == SeedOrigin::kTof) kept_pixels.emplace(seed.tof_u, seed.tof_v);
  }
  return std::ranges::count_if(points, [&](const Seed& point) {
    return Judge(point, scene) == Verdict::kGood &&
           !kept_pixels.contains({point.tof_u, point.tof_v});
  });
}

double RefinementQuality::wrong_before_percent() const {
  return Percent(before.wrong, refined.raw);
}

double RefinementQuality::wrong_after_percent() const {
  return Percent(after.wrong, static_cast<int64_t>(refined.seeds.size()));
}

double RefinementQuality::good_lost_percent() const { return Percent(good_lost, before.good); }

RefinementQuality JudgeRefinement(const Scene& scene, const RefineConfig& config) {
  RefinementQuality quality;
  quality.refined = refine::Refiner(scene.WithRange(config))
                        .Compute(scene.left_grey, scene.right_grey, scene.frame.tof,
                                 scene.projector, scene.frame.tof_zones.value_or(TofZones()))
                        .value_or(SeedSet());
  const std::vector<Seed> points = ProjectAll(scene);
  quality.before = CountSeeds(points, scene);
  quality.after = CountSeeds(quality.refined.seeds, scene);
  quality.good_lost = CountGoodLost(points, quality.refined.seeds, scene);
  return quality;
}

}  // namespace sprout::evaluate
