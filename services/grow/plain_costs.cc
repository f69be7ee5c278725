#include "services/grow/plain_costs.h"

#include <algorithm>
#include <cmath>

#include "services/grow/similarity-inl.h"

namespace sprout::grow {
namespace {

// Over a 5×5 window of the left image, wL, and one of the right image, wR.
struct WindowSums {
  int left = 0, right = 0;                  // Σ wL, Σ wR
  int left_squares = 0, right_squares = 0;  // Σ wL², Σ wR²
  int products = 0;                         // Σ wL·wR
};

WindowSums SumWindows(const GrowthInput& input, const Correspondence& q) {
  WindowSums sums;
  for (int y = q.v - kWindowRadius; y <= q.v + kWindowRadius; ++y) {
    const uint8_t* left = input.left[y] + q.u - kWindowRadius;
    const uint8_t* right = input.right[y] + q.u - q.d - kWindowRadius;
    for (int x = 0; x < kWindow; ++x) {
      sums.left += left[x];
      sums.right += right[x];
      sums.left_squares += left[x] * left[x];
      sums.right_squares += right[x] * right[x];
      sums.products += left[x] * right[x];
    }
  }
  return sums;
}

// Before it is made whole.
float PhotoCostOf(const GrowthRule& rule, const GrowthInput& input, const Correspondence& q) {
  const WindowSums sums = SumWindows(input, q);
  int energy = sums.left_squares + sums.right_squares;
  int difference = energy - 2 * sums.products;
  if (rule.similarity == GrowConfig::MNCC) {  // covariance and variances of eq. (1), times n⁴
    constexpr int kPixels = kWindow * kWindow;
    const int covariance = kPixels * sums.products - sums.left * sums.right;
    energy = kPixels * energy - sums.left * sums.left - sums.right * sums.right;
    energy = std::max(energy, 1);  // without variance no correlation
    difference = energy - 2 * covariance;
  }
  energy = std::max(energy, 1);  // without energy no difference
  return HWY_NAMESPACE::PhotoCost(static_cast<float>(difference), static_cast<float>(energy),
                                  rule.photo_scale);
}

}  // namespace

int32_t CostOf(const GrowthRule& rule, const GrowthInput& input, const Correspondence& q) {
  float cost = PhotoCostOf(rule, input, q);
  if (rule.similarity == GrowConfig::EPC) {  // Eq. (6)
    const int16_t prior = input.prior.disparity.counts()(q.v, q.u);
    if (prior == DisparityImage::kInvalid) return kExcludedCost;
    const int distance = q.d * DisparityImage::kCountsPerPixel - prior;
    const float scale = rule.prior_scales[input.prior.sigma(q.v, q.u)];
    cost += HWY_NAMESPACE::PriorCost(static_cast<float>(distance), scale);
  }
  return static_cast<int32_t>(std::min(cost, kLargestCost));
}

int32_t CostWhereItFits(const GrowthRule& rule, const GrowthInput& input, const Correspondence& q) {
  return WindowsFit(q, input.left.size()) ? CostOf(rule, input, q) : kExcludedCost;
}

int SubPixelStep(const GrowthRule& rule, const GrowthInput& input, const Correspondence& q) {
  const int32_t cost = CostWhereItFits(rule, input, q);
  const int32_t less = CostWhereItFits(rule, input, {q.u, q.v, q.d - 1});
  const int32_t more = CostWhereItFits(rule, input, {q.u, q.v, q.d + 1});
  if (std::max(less, more) == kExcludedCost || std::min(less, more) <= cost) return 0;
  const auto rise = static_cast<float>((less - cost) + (more - cost));
  const float half_px = DisparityImage::kCountsPerPixel / 2.0F;
  const float step = half_px * static_cast<float>(less - more) / rise;
  return std::min(static_cast<int>(std::lrint(step)), kMostStep);
}

}  // namespace sprout::grow
