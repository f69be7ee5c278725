#include "services/refine/surface/range_noise.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "common/core/quantile.h"
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
  const size_t bins =
      std::min(sample.size() / SurfaceRules::kFewestOfBin, SurfaceRules::kNoiseBins);
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

}  // namespace sprout::refine
