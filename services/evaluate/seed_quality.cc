#include "services/evaluate/seed_quality.h"

#include <cmath>
#include <limits>
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

}  // namespace

SeedCounts CountSeeds(std::span<const Seed> seeds, const Scene& scene) {
  SeedCounts counts;
  for (const Seed& seed : seeds) {
    if (!InImage(seed, scene.size())) continue;
    const cv::Point pixel(cvRound(seed.u), cvRound(seed.v));
    const double error = std::abs(double{seed.disparity()} - scene.frame.truth.left(pixel));
    if (error > kWrongSeedPx || scene.occluded(pixel) != 0) {
      ++counts.wrong;
    } else if (scene.nonoccluded(pixel) != 0) {
      ++counts.good;
    }
  }
  return counts;
}

double RefinementQuality::wrong_before_percent() const {
  return Percent(before.wrong, refined.raw);
}

double RefinementQuality::wrong_after_percent() const {
  return Percent(after.wrong, static_cast<int64_t>(refined.seeds.size()));
}

double RefinementQuality::good_lost_percent() const {
  return Percent(before.good - after.good, before.good);
}

RefinementQuality JudgeRefinement(const Scene& scene, const RefineConfig& config) {
  RefinementQuality quality;
  quality.refined =
      refine::Refiner(scene.WithRange(config))
          .Compute(scene.left_grey, scene.right_grey, scene.frame.tof, scene.projector)
          .value_or(SeedSet());
  quality.before = CountSeeds(ProjectAll(scene), scene);
  quality.after = CountSeeds(quality.refined.seeds, scene);
  return quality;
}

}  // namespace sprout::evaluate
