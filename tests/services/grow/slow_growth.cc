#include "tests/services/grow/slow_growth.h"

#include <cmath>
#include <limits>
#include <list>
#include <optional>
#include <set>
#include <tuple>
#include <vector>

namespace sprout {
namespace {

struct Correspondence {
  int u, v, d;
};

std::vector<double> Window(const cv::Mat1b& image, int u, int v) {
  std::vector<double> values;
  for (int y = -2; y <= 2; ++y) {
    for (int x = -2; x <= 2; ++x) values.push_back(image(v + y, u + x));
  }
  return values;
}

// Exponent of EXPSSD without its sign.
double SlowExponent(const cv::Mat1b& left, const cv::Mat1b& right, int u, int v, int d,
                    double sigma_s_squared) {
  const auto wl = Window(left, u, v);
  const auto wr = Window(right, u - d, v);
  double numerator = 0;
  double denominator = 0;
  for (size_t i = 0; i < wl.size(); ++i) {
    numerator += (wl[i] - wr[i]) * (wl[i] - wr[i]);
    denominator += wl[i] * wl[i] + wr[i] * wr[i];
  }
  return denominator == 0 ? 0 : numerator / (sigma_s_squared * denominator);
}

// Rounded as growth rounds: 2^20 steps to one.
int64_t Fixed(double x) {
  return static_cast<int64_t>(std::floor(std::min(x, 1000.0) * 1048576 + 0.5));
}

class SlowGrowth {
 public:
  SlowGrowth(const GrowConfig& config, const cv::Mat1b& left, const cv::Mat1b& right,
             const DisparityImage& prior)
      : config_(config), left_(left), right_(right), prior_(prior), map_(left.size()) {
    limit_ = config.similarity() == GrowConfig::MNCC ? Fixed(1 - config.threshold())
                                                     : Fixed(-std::log(config.threshold()));
  }

  DisparityImage Run(std::span<const Seed> initial) {
    for (const Seed& seed : initial) {
      const Correspondence s{static_cast<int>(std::lround(seed.u)),
                             static_cast<int>(std::lround(seed.v)),
                             static_cast<int>(std::lround(seed.u - seed.u_right))};
      if (Inside(s)) seeds_.emplace_back(Level(Cost(s).value_or(INT32_MAX)), s);
    }
    while (!seeds_.empty()) {
      const Correspondence s = TakeBest();
      for (const auto& [du, dv] : {std::pair{-1, 0}, {1, 0}, {0, -1}, {0, 1}}) {
        Visit({s.u + du, s.v + dv, s.d});
      }
    }
    return map_;
  }

 private:
  bool Inside(const Correspondence& q) const {
    const auto column_fits = [&](int u) { return u >= 2 && u < left_.cols - 2; };
    return q.d >= 0 && column_fits(q.u) && column_fits(q.u - q.d) && q.v >= 2 &&
           q.v < left_.rows - 2;
  }

  std::optional<int64_t> Cost(const Correspondence& q) const {
    if (config_.similarity() == GrowConfig::MNCC) {
      return Fixed(1 - SlowMncc(left_, right_, q.u, q.v, q.d));
    }
    const double photo = SlowExponent(left_, right_, q.u, q.v, q.d, config_.sigma_s_squared());
    if (config_.similarity() == GrowConfig::EXPSSD) return Fixed(photo);
    if (!prior_.IsValid(q.u, q.v)) return std::nullopt;
    const double deviation =
        (q.d * 32 - prior_.counts()(q.v, q.u)) * (1 / (config_.sigma_p_px() * 32));
    return Fixed(photo) + Fixed(deviation * deviation / 2);
  }

  int Level(int64_t cost) const {
    return static_cast<int>(std::min<int64_t>(cost * 256 / (limit_ + 1), 255));
  }

  // Smallest level; the one added last among equals.
  Correspondence TakeBest() {
    auto best = seeds_.begin();
    for (auto it = seeds_.begin(); it != seeds_.end(); ++it) {
      if (it->first <= best->first) best = it;
    }
    const Correspondence s = best->second;
    seeds_.erase(best);
    return s;
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
    if (matched_right_.contains({best->u - best->d, best->v})) return;
    map_.counts()(best->v, best->u) = static_cast<int16_t>(best->d * 32);
    matched_right_.insert({best->u - best->d, best->v});
    seeds_.emplace_back(Level(best_cost), *best);
  }

  const GrowConfig& config_;
  const cv::Mat1b& left_;
  const cv::Mat1b& right_;
  const DisparityImage& prior_;
  DisparityImage map_;
  int64_t limit_ = 0;
  std::list<std::pair<int, Correspondence>> seeds_;  // with their level, in order of arrival
  std::set<std::pair<int, int>> matched_right_;
};

}  // namespace

double SlowMncc(const cv::Mat1b& left, const cv::Mat1b& right, int u, int v, int d) {
  const auto wl = Window(left, u, v);
  const auto wr = Window(right, u - d, v);
  // Sums of whole numbers instead of means, so that equal windows give exactly 1.
  double sum_l = 0, sum_r = 0, sum_ll = 0, sum_rr = 0, sum_lr = 0;
  for (size_t i = 0; i < wl.size(); ++i) {
    sum_l += wl[i];
    sum_r += wr[i];
    sum_ll += wl[i] * wl[i];
    sum_rr += wr[i] * wr[i];
    sum_lr += wl[i] * wr[i];
  }
  const double n = static_cast<double>(wl.size());
  const double covariance = n * sum_lr - sum_l * sum_r;
  const double variances = (n * sum_ll - sum_l * sum_l) + (n * sum_rr - sum_r * sum_r);
  return 2 * covariance / (variances + std::numeric_limits<double>::epsilon());
}

double SlowExpssd(const cv::Mat1b& left, const cv::Mat1b& right, int u, int v, int d,
                  double sigma_s_squared) {
  return std::exp(-SlowExponent(left, right, u, v, d, sigma_s_squared));
}

double SlowPrior(double d, double prior, double sigma_p_px) {
  return std::exp(-(d - prior) * (d - prior) / (2 * sigma_p_px * sigma_p_px));
}

DisparityImage SlowGrow(const GrowConfig& config, const cv::Mat1b& left, const cv::Mat1b& right,
                        std::span<const Seed> seeds, const DisparityImage& prior) {
  return SlowGrowth(config, left, right, prior).Run(seeds);
}

}  // namespace sprout
