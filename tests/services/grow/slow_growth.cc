#include "tests/services/grow/slow_growth.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <vector>

namespace sprout {
namespace {

struct Correspondence {
  int u, v, d;
};

std::vector<int64_t> Window(const cv::Mat1b& image, int u, int v) {
  std::vector<int64_t> values;
  for (int y = -2; y <= 2; ++y) {
    for (int x = -2; x <= 2; ++x) values.push_back(image(v + y, u + x));
  }
  return values;
}

// Σ (wL − wR)² and Σ (wL² + wR²).
struct SquaredSums {
  int64_t difference = 0;
  int64_t energy = 0;
};

SquaredSums SumSquares(const cv::Mat1b& left, const cv::Mat1b& right, int u, int v, int d) {
  const auto wl = Window(left, u, v);
  const auto wr = Window(right, u - d, v);
  SquaredSums sums;
  for (size_t i = 0; i < wl.size(); ++i) {
    sums.difference += (wl[i] - wr[i]) * (wl[i] - wr[i]);
    sums.energy += wl[i] * wl[i] + wr[i] * wr[i];
  }
  return sums;
}

// cov and var + var of eq. (1), times n⁴: sums of whole numbers instead of means.
struct MnccSums {
  int64_t covariance;
  int64_t variances;
};

MnccSums SumMncc(const cv::Mat1b& left, const cv::Mat1b& right, int u, int v, int d) {
  const auto wl = Window(left, u, v);
  const auto wr = Window(right, u - d, v);
  int64_t sum_l = 0, sum_r = 0, sum_ll = 0, sum_rr = 0, sum_lr = 0;
  for (size_t i = 0; i < wl.size(); ++i) {
    sum_l += wl[i];
    sum_r += wr[i];
    sum_ll += wl[i] * wl[i];
    sum_rr += wr[i] * wr[i];
    sum_lr += wl[i] * wr[i];
  }
  const auto n = static_cast<int64_t>(wl.size());
  return {n * sum_lr - sum_l * sum_r, (n * sum_ll - sum_l * sum_l) + (n * sum_rr - sum_r * sum_r)};
}

// 2^20 steps to one.
constexpr double kUnit = 1048576;
constexpr float kLargest = 134217728;  // 2^27

// −ln τ, rounded.
int64_t Limit(const GrowConfig& config) {
  const double limit = config.similarity() == GrowConfig::MNCC ? 1 - config.threshold()
                                                               : -std::log(config.threshold());
  return static_cast<int64_t>(std::floor(limit * kUnit + 0.5));
}

// Alg. 1 in bands of equal height, 64 rows at most.
class SlowGrowth {
 public:
  SlowGrowth(const GrowConfig& config, const cv::Mat1b& left, const cv::Mat1b& right,
             const PriorMap& prior)
      : config_(config),
        left_(left),
        right_(right),
        prior_(prior),
        map_(left.size()),
        right_matched_(left.size(), uint8_t{0}),
        limit_(Limit(config)),
        seeds_(static_cast<size_t>((left.rows + 63) / 64)),
        band_rows_((left.rows + bands() - 1) / bands()) {}

  DisparityImage Run(std::span<const Seed> initial) {
    for (const Seed& seed : initial) {
      const Correspondence s{static_cast<int>(std::lround(seed.u)),
                             static_cast<int>(std::lround(seed.v)),
                             static_cast<int>(std::lround(seed.u - seed.u_right))};
      if (Inside(s)) Add(s, Cost(s).value_or(INT32_MAX));
    }
    for (int band = 0; band < bands(); ++band) GrowBand(band);
    // From the borders of the neighbours, as the round before has left them, until all is at rest.
    bool changed = true;
    while (changed) {
      const cv::Mat1s before = map_.counts().clone();
      for (int band = 0; band < bands(); ++band) {
        const int top = band * band_rows_;
        const int bottom = std::min(top + band_rows_, left_.rows) - 1;
        if (band > 0) CrossFrom(before, top - 1, top);
        if (band + 1 < bands()) CrossFrom(before, bottom + 1, bottom);
        GrowBand(band);
      }
      changed = cv::countNonZero(before != map_.counts()) > 0;
    }
    return config_.sub_pixel() ? WithSubPixelSteps() : map_;
  }

 private:
  int bands() const { return static_cast<int>(seeds_.size()); }

  bool Inside(const Correspondence& q) const {
    const auto column_fits = [&](int u) { return u >= 2 && u < left_.cols - 2; };
    return q.d >= 0 && column_fits(q.u) && column_fits(q.u - q.d) && q.v >= 2 &&
           q.v < left_.rows - 2;
  }

  // Of the square of counts. Where σ_p leaves two disparities it is sigma_p_px.
  float PriorScale(uint8_t sigma) const {
    const auto scale_of = [](double sigma_p_px) {
      return static_cast<float>(kUnit / (2 * (sigma_p_px * 32) * (sigma_p_px * 32)));
    };
    const double sigma_px = sigma / 16.0;
    const double sure = config_.sigma_p_sure_px();
    const float scale = scale_of(std::max(
        config_.sigma_p_px(),
        config_.sigma_p_noise() * std::sqrt(std::max(0.0, sigma_px * sigma_px - sure * sure))));
    const bool open = 32 * 32 * scale < static_cast<float>(limit_ + 1);
    return open ? scale : scale_of(config_.sigma_p_px());
  }

  // In the steps in which growth computes: whole numbers, and floats of 24 binary places.
  std::optional<int64_t> Cost(const Correspondence& q) const {
    if (config_.similarity() == GrowConfig::MNCC) {
      const MnccSums sums = SumMncc(left_, right_, q.u, q.v, q.d);
      const int64_t variances = std::max<int64_t>(sums.variances, 1);
      return static_cast<int64_t>(static_cast<float>(variances - 2 * sums.covariance) *
                                  (static_cast<float>(kUnit) / static_cast<float>(variances)));
    }
    const auto [difference, energy] = SumSquares(left_, right_, q.u, q.v, q.d);
    float cost =
        static_cast<float>(difference) * (static_cast<float>(kUnit / config_.sigma_s_squared()) /
                                          static_cast<float>(std::max<int64_t>(energy, 1)));
    if (config_.similarity() == GrowConfig::EPC) {
      if (!prior_.disparity.IsValid(q.u, q.v)) return std::nullopt;
      const auto distance = static_cast<float>(q.d * 32 - prior_.disparity.counts()(q.v, q.u));
      cost += distance * distance * PriorScale(prior_.sigma(q.v, q.u));
    }
    return static_cast<int64_t>(std::min(cost, kLargest));
  }

  // Into one of 256 levels of equal width; beyond the limit all share the last.
  void Add(const Correspondence& s, int64_t cost) {
    const int64_t levels_per_cost = (int64_t{256} << 22) / (limit_ + 1);
    const int64_t level = std::min(cost, limit_) * levels_per_cost >> 22;
    seeds_[static_cast<size_t>(s.v / band_rows_)][level].push_back(s);
  }

  void GrowBand(int band) {
    auto& levels = seeds_[static_cast<size_t>(band)];
    while (!levels.empty()) {
      // Smallest level; the one added last among equals.
      auto& best = levels.begin()->second;
      const Correspondence s = best.back();
      best.pop_back();
      if (best.empty()) levels.erase(levels.begin());
      for (const auto& [du, dv] : {std::pair{-1, 0}, {1, 0}, {0, -1}, {0, 1}}) {
        const int v = s.v + dv;
        if (v >= 0 && v / band_rows_ == band) Visit({s.u + du, v, s.d});
      }
    }
  }

  void CrossFrom(const cv::Mat1s& before, int from, int to) {
    for (int u = 0; u < left_.cols; ++u) {
      if (before(from, u) != DisparityImage::kInvalid) Visit({u, to, before(from, u) / 32});
    }
  }

  void Visit(const Correspondence& near) {
    std::optional<Correspondence> best;
    int64_t best_cost = INT32_MAX;
    for (const int step : {0, -1, 1}) {
      const Correspondence q{near.u, near.v, near.d + step};
      if (!Inside(q)) continue;
      const std::optional<int64_t> cost = Cost(q);
      if (cost && *cost < best_cost) {
        best = q;
        best_cost = *cost;
      }
    }
    if (!best || best_cost > limit_) return;
    if (map_.IsValid(best->u, best->v)) return;
    uint8_t& right_matched = right_matched_(best->v, best->u - best->d);
    if (right_matched != 0) return;
    map_.counts()(best->v, best->u) = static_cast<int16_t>(best->d * 32);
    right_matched = 1;
    Add(*best, best_cost);
  }

  // To the minimum of the parabola through three costs, where the middle one is the least.
  DisparityImage WithSubPixelSteps() const {
    DisparityImage stepped(map_.counts().clone());
    for (int v = 0; v < map_.height(); ++v) {
      for (int u = 0; u < map_.width(); ++u) {
        if (!map_.IsValid(u, v)) continue;
        const Correspondence q{u, v, map_.counts()(v, u) / 32};
        const Correspondence less{u, v, q.d - 1}, more{u, v, q.d + 1};
        if (!Inside(less) || !Inside(more)) continue;
        const int64_t before = *Cost(less) - *Cost(q), behind = *Cost(more) - *Cost(q);
        if (before <= 0 || behind <= 0) continue;
        const float step =
            16 * static_cast<float>(before - behind) / static_cast<float>(before + behind);
        stepped.counts()(v, u) += static_cast<int16_t>(std::lrint(step));
      }
    }
    return stepped;
  }

  const GrowConfig& config_;
  const cv::Mat1b& left_;
  const cv::Mat1b& right_;
  const PriorMap& prior_;
  DisparityImage map_;
  cv::Mat1b right_matched_;
  int64_t limit_;
  std::vector<std::map<int64_t, std::vector<Correspondence>>> seeds_;  // of each band, by level
  int band_rows_;
};

}  // namespace

double SlowMncc(const cv::Mat1b& left, const cv::Mat1b& right, int u, int v, int d) {
  const MnccSums sums = SumMncc(left, right, u, v, d);
  return 2 * static_cast<double>(sums.covariance) /
         (static_cast<double>(sums.variances) + std::numeric_limits<double>::epsilon());
}

double SlowExpssd(const cv::Mat1b& left, const cv::Mat1b& right, int u, int v, int d,
                  double sigma_s_squared) {
  const auto [difference, energy] = SumSquares(left, right, u, v, d);
  if (energy == 0) return 1;
  return std::exp(-static_cast<double>(difference) /
                  (sigma_s_squared * static_cast<double>(energy)));
}

double SlowPrior(double d, double prior, double sigma_p_px) {
  return std::exp(-(d - prior) * (d - prior) / (2 * sigma_p_px * sigma_p_px));
}

DisparityImage SlowGrow(const GrowConfig& config, const cv::Mat1b& left, const cv::Mat1b& right,
                        std::span<const Seed> seeds, const PriorMap& prior) {
  return SlowGrowth(config, left, right, prior).Run(seeds);
}

}  // namespace sprout
