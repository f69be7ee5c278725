#include "services/refine/surface/range_noise.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "common/core/quantile.h"
#include "common/core/window_sums.h"
#include "services/refine/surface/surface_rules.h"

namespace sprout::refine {
namespace {

constexpr int kPowers = 3;

double Power(double base_px, int power) {
  const double base = std::max(1.0, base_px);
  double product = 1;
  for (int i = 0; i < power; ++i) product *= base;
  return product;
}

// The standard deviation of points of which these are the deviations.
double SigmaOf(std::vector<float>& offs) {
  return Quantile(offs, SurfaceRules::kNoiseShare) /
         (SurfaceRules::kNoiseQuantile * std::sqrt(SurfaceRules::kNoiseVariance));
}

// @param sample  sorted by disparity.
int PowerOf(std::span<const Deviation> sample, double infinity_px) {
  const size_t bins = std::min(sample.size() / SurfaceRules::kMinPerBin, SurfaceRules::kNoiseBins);
  std::array<double, kPowers> least, most;
  least.fill(HUGE_VAL);
  most.fill(0);
  std::vector<float> offs;
  for (size_t bin = 0; bin < bins; ++bin) {
    const size_t begin = sample.size() * bin / bins;
    const size_t end = sample.size() * (bin + 1) / bins;
    offs.clear();
    for (size_t i = begin; i < end; ++i) offs.push_back(sample[i].off_px);
    const double sigma_px = std::max(SurfaceRules::kMinSigmaPx, SigmaOf(offs));
    const double middle_px = sample[(begin + end) / 2].disparity_px - infinity_px;
    for (int power = 0; power < kPowers; ++power) {
      const double scale = sigma_px / Power(middle_px, power);
      const auto i = static_cast<size_t>(power);
      least[i] = std::min(least[i], scale);
      most[i] = std::max(most[i], scale);
    }
  }
  size_t best = 0;
  for (size_t power = 1; power < kPowers; ++power) {
    if (most[power] / least[power] < SurfaceRules::kEvener * most[best] / least[best]) best = power;
  }
  return static_cast<int>(best);
}

constexpr int kNoiseRadius = SurfaceRules::kRadius;
constexpr int kReach = SurfaceRules::kMatchReachPx;

struct Match {
  double sharpness = 0;     // of the minimum: curvature over the difference that is left
  double deviation_px = 0;  // from the point's disparity
};

// Where the windows of a point differ least; nothing where that is on the end of the range.
std::optional<Match> MatchOf(const cv::Mat1b& left, const cv::Mat1b& right, const Seed& seed) {
  const double u = std::round(double{seed.u});
  const double u_right = u - seed.disparity();
  if (!IsInside(u, seed.v, left.size(), kNoiseRadius - 0.5) ||
      !IsInside(u_right, seed.v, right.size(), kNoiseRadius + kReach, kNoiseRadius - 0.5)) {
    return {};
  }
  const cv::Point at_left(static_cast<int>(u), static_cast<int>(std::lround(seed.v)));
  const int first = static_cast<int>(std::lround(u_right)) - kReach;
  std::array<int, 2 * kReach + 1> differences{};
  for (int i = 0; i <= 2 * kReach; ++i) {
    const WindowSums sums = SumWindows<kNoiseRadius>(left, right, at_left, {first + i, at_left.y});
    differences[static_cast<size_t>(i)] =
        sums.left_squares + sums.right_squares - 2 * sums.products;
  }
  const auto best = std::min_element(differences.begin(), differences.end());
  if (best == differences.begin() || best + 1 == differences.end()) return {};
  const int curvature = best[-1] - 2 * best[0] + best[1];
  if (curvature <= 0) return {};
  const double fraction = (best[-1] - best[1]) / (2.0 * curvature);
  const double column = first + static_cast<double>(best - differences.begin()) + fraction;
  return Match{curvature / (best[0] + 1.0), std::abs(column - u_right)};
}

}  // namespace

double RangeNoise::PxAt(double disparity_px) const {
  return std::clamp(scale * Power(disparity_px - infinity_px, power), SurfaceRules::kMinSigmaPx,
                    SurfaceRules::kMaxSigmaPx);
}

RangeNoise FindRangeNoise(const std::vector<Deviation>& deviations, double infinity_px) {
  RangeNoise noise{.infinity_px = infinity_px};
  if (deviations.empty()) return noise;
  std::vector<Deviation> sample;
  for (size_t i = 0; i < deviations.size();
       i += deviations.size() / SurfaceRules::kNoiseSample + 1) {
    sample.push_back(deviations[i]);
  }
  std::ranges::sort(sample, {}, &Deviation::disparity_px);
  noise.power = PowerOf(sample, infinity_px);
  const auto power_at = [&](const Deviation& deviation) {
    return Power(deviation.disparity_px - infinity_px, noise.power);
  };
  std::vector<float> offs;
  offs.reserve(deviations.size());
  for (const Deviation& deviation : deviations) {
    offs.push_back(static_cast<float>(deviation.off_px / power_at(deviation)));
  }
  noise.scale = SigmaOf(offs);
  noise.middle_px = noise.scale * power_at(sample[sample.size() / 2]);
  return noise;
}

std::vector<double> NoiseOfBlocks(const std::vector<Deviation>& deviations, size_t blocks) {
  std::vector<std::vector<float>> offs(blocks);
  for (const Deviation& deviation : deviations) offs[deviation.block].push_back(deviation.off_px);
  std::vector<double> noise_px;
  for (std::vector<float>& of_block : offs) {
    const bool few = of_block.size() < SurfaceRules::kMinPerBlock;
    noise_px.push_back(few ? 0 : SigmaOf(of_block));
  }
  return noise_px;
}

double ImageNoisePx(const cv::Mat1b& left, const cv::Mat1b& right,
                    std::span<const ProjectedPoint> points) {
  std::vector<Match> matches;
  for (size_t i = 0; i < points.size(); i += points.size() / SurfaceRules::kMatchedPoints + 1) {
    if (const auto match = MatchOf(left, right, points[i].seed)) matches.push_back(*match);
  }
  if (matches.empty()) return std::numeric_limits<double>::infinity();
  std::stable_sort(matches.begin(), matches.end(),
                   [](const Match& a, const Match& b) { return a.sharpness > b.sharpness; });
  matches.resize((matches.size() + SurfaceRules::kSharpest - 1) / SurfaceRules::kSharpest);
  std::vector<double> deviations;
  for (const Match& match : matches) deviations.push_back(match.deviation_px);
  const double sigma_px = Quantile(deviations, 0.5) / SurfaceRules::kMedianOfNormal;
  constexpr double kMatch = SurfaceRules::kMatchSigmaPx;
  return std::sqrt(std::max(0.0, sigma_px * sigma_px - kMatch * kMatch));
}

}  // namespace sprout::refine
