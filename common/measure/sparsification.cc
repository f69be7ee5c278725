#include "common/measure/sparsification.h"

#include <algorithm>
#include <cmath>

namespace sprout {
namespace {

constexpr int kFineSteps = 100;

// Numbers of pixels by confidence.
struct Histogram {
  std::array<double, 256> pixels{};
  std::array<double, 256> bad{};
  double all_pixels = 0;
  double all_bad = 0;

  void Add(int confidence, bool is_bad) {
    const auto level = static_cast<size_t>(confidence);
    pixels[level] += 1;
    all_pixels += 1;
    bad[level] += is_bad;
    all_bad += is_bad;
  }

  // Share of bad pixels among the best `kept` ones, per cent.
  double BadPercent(double kept) const {
    double taken = 0;
    double taken_bad = 0;
    for (size_t level = pixels.size(); level-- > 0 && taken < kept;) {
      if (pixels[level] == 0) continue;
      const double share = std::min(1.0, (kept - taken) / pixels[level]);
      taken += share * pixels[level];
      taken_bad += share * bad[level];
    }
    return 100 * taken_bad / kept;
  }

  double OracleBadPercent(double kept) const {
    return 100 * std::max(0.0, kept - (all_pixels - all_bad)) / kept;
  }
};

}  // namespace

Sparsification Sparsify(const cv::Mat1f& disparity_px, const cv::Mat1f& truth,
                        const cv::Mat1b& mask, const cv::Mat1b& confidence) {
  Histogram histogram;
  for (int v = 0; v < truth.rows; ++v) {
    for (int u = 0; u < truth.cols; ++u) {
      if (mask(v, u) == 0 || !std::isfinite(truth(v, u))) continue;
      const double error = std::abs(double{disparity_px(v, u)} - double{truth(v, u)});
      histogram.Add(confidence(v, u), !(error <= 1));  // NaN is bad
    }
  }
  Sparsification result;
  for (int i = 1; i <= kFineSteps; ++i) {
    const double kept = histogram.all_pixels * i / kFineSteps;
    const double bad_percent = histogram.BadPercent(kept);
    result.area_percent += bad_percent / kFineSteps;
    result.oracle_area_percent += histogram.OracleBadPercent(kept) / kFineSteps;
    constexpr int kRatio = kFineSteps / Sparsification::kSteps;
    if (i % kRatio == 0) result.bad1_percent[static_cast<size_t>(i / kRatio - 1)] = bad_percent;
  }
  return result;
}

}  // namespace sprout
