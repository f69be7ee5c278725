#include "services/grow/paper/plain_costs.h"

#include <algorithm>
#include <cmath>

#include "common/core/window_sums.h"
#include "services/grow/paper/similarity-inl.h"

namespace sprout::grow {
namespace {

// Numerator and denominator of eq. (4), and of 1 − MNCC.
struct Photo {
  int difference, energy;
};

Photo PhotoOf(const GrowthRule& rule, const WindowSums& sums) {
  int energy = sums.left_squares + sums.right_squares;
  int difference = energy - 2 * sums.products;
  if (rule.similarity == GrowConfig::MNCC) {  // covariance and variances of eq. (1), times n⁴
    constexpr int kPixels = kWindow * kWindow;
    const int covariance = kPixels * sums.products - sums.left * sums.right;
    energy = kPixels * energy - sums.left * sums.left - sums.right * sums.right;
    energy = std::max(energy, 1);  // without variance no correlation
    difference = energy - 2 * covariance;
  }
  return {difference, std::max(energy, 1)};  // without energy no difference
}

Photo PhotoAt(const GrowthRule& rule, const GrowthInput& input, const Correspondence& q) {
  return PhotoOf(rule,
                 SumWindows<kWindowRadius>(input.left, input.right, {q.u, q.v}, {q.u - q.d, q.v}));
}

// How much the left windows of two neighbouring pixels differ.
int TextureBetween(const GrowthRule& rule, const GrowthInput& input, int u, int v) {
  const WindowSums sums = SumWindows<kWindowRadius>(input.left, input.left, {u, v}, {u - 1, v});
  return std::max(1, PhotoOf(rule, sums).difference);
}

}  // namespace

int32_t CostOf(const GrowthRule& rule, const GrowthInput& input, const Correspondence& q) {
  const Photo photo = PhotoAt(rule, input, q);
  float cost = HWY_NAMESPACE::PhotoCost(static_cast<float>(photo.difference),
                                        static_cast<float>(photo.energy), rule.photo_scale);
  if (rule.similarity == GrowConfig::EPC) {  // Eq. (6): by eqs. (2), (3) a product, so costs add
    const int16_t prior = input.prior.disparity.counts()(q.v, q.u);
    if (prior == DisparityImage::kInvalid) return kExcludedCost;
    const int distance = q.d * DisparityImage::kCountsPerPixel - prior;
    const float scale = rule.prior_scales[input.prior.sigma(q.v, q.u)];
    cost += HWY_NAMESPACE::PriorCost(static_cast<float>(distance), scale);
  }
  return static_cast<int32_t>(std::min(cost, kMaxCost));
}

int32_t CostWhereItFits(const GrowthRule& rule, const GrowthInput& input, const Correspondence& q) {
  return WindowsFit(q, input.left.size()) ? CostOf(rule, input, q) : kExcludedCost;
}

int SubPixelStep(const GrowthRule& rule, const GrowthInput& input, const Correspondence& q) {
  const Correspondence before{q.u, q.v, q.d - 1};
  const Correspondence behind{q.u, q.v, q.d + 1};
  const int32_t cost = CostWhereItFits(rule, input, q);
  const int32_t less = CostWhereItFits(rule, input, before);
  const int32_t more = CostWhereItFits(rule, input, behind);
  const bool has_next = q.u + 1 < input.left.cols - kWindowRadius;
  if (std::max(less, more) == kExcludedCost || std::min(less, more) <= cost || !has_next) return 0;
  const Photo photo = PhotoAt(rule, input, q);
  const int below = PhotoAt(rule, input, before).difference;
  const int above = PhotoAt(rule, input, behind).difference;
  const bool up = above < below;
  float distance = 0;
  float prior_scale = 0;
  if (rule.similarity == GrowConfig::EPC) {
    constexpr int kPixel = DisparityImage::kCountsPerPixel;
    distance = static_cast<float>(q.d * kPixel - input.prior.disparity.counts()(q.v, q.u));
    prior_scale = rule.prior_scales[input.prior.sigma(q.v, q.u)] * (kPixel * kPixel);
  }
  const HWY_NAMESPACE::StepInput<float> in{
      .fall = static_cast<float>(photo.difference - std::min(below, above)),
      .texture = static_cast<float>(TextureBetween(rule, input, up ? q.u : q.u + 1, q.v)),
      .energy = static_cast<float>(photo.energy),
      .side = static_cast<float>(up ? DisparityImage::kCountsPerPixel
                                    : -DisparityImage::kCountsPerPixel),
      .distance = distance,
      .photo_scale = rule.photo_scale,
      .prior_scale = prior_scale};
  const float step = HWY_NAMESPACE::StepToMinimum(in, [](float number) { return number; });
  return static_cast<int>(
      std::lrint(HWY_NAMESPACE::Clamped(step, -kMaxStep - 1.0F, static_cast<float>(kMaxStep))));
}

}  // namespace sprout::grow
