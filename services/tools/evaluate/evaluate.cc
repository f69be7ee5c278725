#include "services/tools/evaluate/evaluate.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

#include "common/core/prior_map.h"
#include "common/core/quantile.h"
#include "services/refine/refiner.h"

namespace sprout::evaluate {
namespace {

struct Level {
  double pixels = 0;
  double bad = 0;
};

// Surest first; pixels of one confidence are spread evenly over the bins that it belongs to.
void FillBins(const std::array<Level, 256>& levels, double all, Calibration& result) {
  const double size = all / Calibration::kBins;
  size_t level = levels.size() - 1;
  double left = levels[level].pixels;  // of the level
  for (Calibration::Bin& bin : result.bins) {
    double room = size;
    double claimed = 0;
    double bad = 0;
    while (room > 0) {
      while (left <= 0 && level > 0) left = levels[--level].pixels;
      const double taken = level == 0 ? room : std::min(room, left);
      claimed += taken * (1 - static_cast<double>(level) / 255);
      if (levels[level].pixels > 0) bad += taken * levels[level].bad / levels[level].pixels;
      left -= taken;
      room -= taken;
    }
    bin = {.claimed_percent = 100 * claimed / size, .bad1_percent = 100 * bad / size};
    result.error_points += std::abs(bin.claimed_percent - bin.bad1_percent) / Calibration::kBins;
  }
}

double Percent(int64_t part, int64_t whole) {
  if (whole == 0) return std::numeric_limits<double>::quiet_NaN();
  return 100.0 * static_cast<double>(part) / static_cast<double>(whole);
}

// Compares before converting to int: points beside the cameras may project far outside of its
// range.
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

double MedianOf(const std::vector<StageTimes>& runs, double StageTimes::*stage) {
  std::vector<double> times;
  for (const StageTimes& run : runs) times.push_back(run.*stage);
  return Median(times);
}

StageTimes Medians(const std::vector<StageTimes>& runs) {
  StageTimes median;
  for (double StageTimes::*stage :
       {&StageTimes::refine_ms, &StageTimes::prior_ms, &StageTimes::grow_ms, &StageTimes::fill_ms,
        &StageTimes::total_ms}) {
    median.*stage = MedianOf(runs, stage);
  }
  return median;
}

cv::Mat1b TestPixels(const Scene& scene) {
  if (!scene.truth_is_scan) return scene.nonoccluded;
  cv::Mat1b both;
  cv::bitwise_and(scene.nonoccluded, scene.away, both);
  return both;
}

MethodResult EvaluateMethod(const Scene& scene, const Method& method, const ChainSettings& settings,
                            int repeat) {
  MethodOutput output;
  std::vector<StageTimes> runs;
  for (int i = 0; i < repeat; ++i) {
    output = method.run(scene, settings);
    runs.push_back(output.ms);
  }
  const cv::Mat1f& truth = scene.frame.truth.left;
  const cv::Mat1b everywhere(scene.size(), uchar{255});
  std::optional<Sparsification> confidence;
  std::optional<Calibration> calibration;
  if (!output.confidence.empty()) {
    const cv::Mat1b scored = TestPixels(scene);
    confidence = Sparsify(output.map_px, truth, scored, output.confidence);
    if (!output.sigma.empty()) {
      calibration = Calibrate(output.map_px, truth, scored, output.confidence, output.sigma);
    }
  }
  return {.name = method.name,
          .nonoccluded = Score(output.map_px, truth, scene.nonoccluded).value(),
          .all = Score(output.map_px, truth, everywhere).value(),
          .away = Score(output.map_px, truth, scene.away).value(),
          .confidence = confidence,
          .calibration = calibration,
          .ms = Medians(runs),
          .map_px = output.map_px};
}

}  // namespace

Calibration Calibrate(const cv::Mat1f& disparity_px, const cv::Mat1f& truth, const cv::Mat1b& mask,
                      const cv::Mat1b& confidence, const cv::Mat1b& sigma) {
  std::array<Level, 256> levels{};
  double all = 0;
  double bad = 0;
  double claimed = 0;
  double within_1 = 0;
  double within_2 = 0;
  for (int v = 0; v < truth.rows; ++v) {
    for (int u = 0; u < truth.cols; ++u) {
      const double error = std::abs(double{disparity_px(v, u)} - double{truth(v, u)});
      if (mask(v, u) == 0 || !std::isfinite(error)) continue;
      Level& level = levels[confidence(v, u)];
      level.pixels += 1;
      level.bad += error > 1;
      all += 1;
      bad += error > 1;
      claimed += 1 - confidence(v, u) / 255.0;
      const double sigma_px = double{SigmaToPx(sigma(v, u))};
      within_1 += error <= sigma_px;
      within_2 += error <= 2 * sigma_px;
    }
  }
  Calibration result;
  result.claimed_percent = 100 * claimed / all;
  result.bad1_percent = 100 * bad / all;
  result.within_1_sigma_percent = 100 * within_1 / all;
  result.within_2_sigma_percent = 100 * within_2 / all;
  if (all > 0) {
    FillBins(levels, all, result);
  } else {
    result.error_points = std::nan("");
  }
  return result;
}

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
  refine::Refiner refiner(scene.WithRange(config));
  quality.refined = refiner
                        .Compute(scene.left_grey, scene.right_grey, scene.frame.tof,
                                 scene.projector, scene.frame.tof_zones.value_or(TofZones()))
                        .value_or(SeedSet());
  const std::vector<Seed> points = ProjectAll(scene);
  quality.before = CountSeeds(points, scene);
  quality.after = CountSeeds(quality.refined.seeds, scene);
  std::vector<Seed> kept;
  Join(quality.refined.seeds, refiner.left_seeds().seeds, kept);
  quality.good_lost = CountGoodLost(points, kept, scene);
  return quality;
}

SceneResult EvaluateScene(const Scene& scene, const std::vector<Method>& methods,
                          const ChainSettings& settings, int repeat, const OnMethod& on_method) {
  SceneResult result{.name = scene.name,
                     .size = scene.size(),
                     .refinement = JudgeRefinement(scene, settings.config.refine())};
  for (const Method& method : methods) {
    on_method(method);
    result.methods.push_back(EvaluateMethod(scene, method, settings, repeat));
  }
  return result;
}

}  // namespace sprout::evaluate
