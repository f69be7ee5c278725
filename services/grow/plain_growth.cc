#include "services/grow/plain_growth.h"

#include <algorithm>
#include <cmath>
#include <queue>
#include <vector>

#include "common/core/parallel.h"
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

class PlainGrowth {
 public:
  PlainGrowth(const GrowthRule& rule, const GrowthInput& input)
      : rule_(rule),
        input_(input),
        map_(input.left.size()),
        right_matched_(input.right.size(), uint8_t{0}),
        band_rows_(RowsPerBand(input.left.rows)),
        seeds_(static_cast<size_t>(CountBands(input.left.rows))) {}

  // Alg. 1 in each band of rows, and from band to band until none grows any more.
  DisparityImage Run(std::span<const Correspondence> seeds) {
    for (const Correspondence& s : seeds) AddSeed(s, CostOf(rule_, input_, s));  // Step 2
    ForEachParallel(seeds_.size(), [&](size_t band) { Grow(seeds_[band]); });
    for (bool changed = true; changed;) {
      const cv::Mat1s before = map_.counts().clone();
      ForEachParallel(seeds_.size(), [&](size_t band) {
        const int top = static_cast<int>(band) * band_rows_;
        const int end = std::min(top + band_rows_, map_.height());
        CrossFrom(before, top - 1, top);
        CrossFrom(before, end, end - 1);
        Grow(seeds_[band]);
      });
      changed = cv::countNonZero(before != map_.counts()) > 0;
    }
    return rule_.sub_pixel ? WithSubPixelSteps() : map_;
  }

 private:
  // A correspondence in the queue. The smallest level first, of one level the last one added.
  struct QueuedSeed {
    Correspondence at;
    int level;
    size_t number;  // in the order of adding
    bool operator<(const QueuedSeed& other) const {
      return level != other.level ? level > other.level : number < other.number;
    }
  };
  // The seeds of a band of rows.
  struct Seeds {
    std::priority_queue<QueuedSeed> queue;
    size_t added = 0;
  };

  size_t BandOf(int v) const { return static_cast<size_t>(v / band_rows_); }

  void AddSeed(const Correspondence& s, int32_t cost) {
    Seeds& seeds = seeds_[BandOf(s.v)];
    seeds.queue.push({s, rule_.LevelOf(cost), seeds.added++});
  }

  void Grow(Seeds& seeds) {
    while (!seeds.queue.empty()) {                    // Steps 4 and 13
      const Correspondence s = seeds.queue.top().at;  // Step 5
      seeds.queue.pop();
      VisitInBand(BandOf(s.v), {s.u - 1, s.v, s.d});  // Step 6
      VisitInBand(BandOf(s.v), {s.u + 1, s.v, s.d});
      VisitInBand(BandOf(s.v), {s.u, s.v - 1, s.d});
      VisitInBand(BandOf(s.v), {s.u, s.v + 1, s.d});
    }
  }

  void VisitInBand(size_t band, const Correspondence& near) {
    if (near.v >= 0 && BandOf(near.v) == band) Visit(near);
  }

  // The best of three disparities; of equals d comes before d − 1 before d + 1.
  void Visit(const Correspondence& near) {
    Correspondence best = near;
    int32_t best_cost = kExcludedCost;
    for (const int step : {0, -1, 1}) {
      const Correspondence q{near.u, near.v, near.d + step};
      const int32_t cost = CostWhereItFits(q);
      if (cost < best_cost) {
        best = q;
        best_cost = cost;
      }
    }
    if (best_cost > rule_.limit) return;  // Step 7
    if (map_.IsValid(best.u, best.v)) return;
    uint8_t& right_matched = right_matched_(best.v, best.u - best.d);
    if (right_matched != 0) return;  // Step 8
    AddSeed(best, best_cost);        // Step 9
    map_.counts()(best.v, best.u) =  // Step 10
        static_cast<int16_t>(best.d * DisparityImage::kCountsPerPixel);
    right_matched = 1;
  }

  int32_t CostWhereItFits(const Correspondence& q) const {
    return WindowsFit(q, map_.size()) ? CostOf(rule_, input_, q) : kExcludedCost;
  }

  // From the pixels of a neighbouring band, from left to right, as the last round has left them.
  void CrossFrom(const cv::Mat1s& before, int from, int to) {
    if (from < 0 || from >= before.rows) return;
    for (int u = 0; u < before.cols; ++u) {
      const int16_t counts = before(from, u);
      if (counts == DisparityImage::kInvalid) continue;
      Visit({u, to, counts / DisparityImage::kCountsPerPixel});
    }
  }

  // Each disparity d moved to the minimum of the parabola through the costs of d − 1, d and d + 1,
  // where d has the least (S2).
  DisparityImage WithSubPixelSteps() const {
    DisparityImage moved(map_.counts().clone());
    for (int v = 0; v < map_.height(); ++v) {
      for (int u = 0; u < map_.width(); ++u) {
        if (!map_.IsValid(u, v)) continue;
        const int d = map_.counts()(v, u) / DisparityImage::kCountsPerPixel;
        const int32_t less = CostWhereItFits({u, v, d - 1}), more = CostWhereItFits({u, v, d + 1});
        const int32_t cost = CostWhereItFits({u, v, d});
        if (std::max(less, more) == kExcludedCost || std::min(less, more) <= cost) continue;
        const auto rise = static_cast<float>((less - cost) + (more - cost));
        const float half_px = DisparityImage::kCountsPerPixel / 2.0F;
        const float step = half_px * static_cast<float>(less - more) / rise;
        moved.counts()(v, u) += static_cast<int16_t>(std::lrint(step));
      }
    }
    return moved;
  }

  const GrowthRule& rule_;
  const GrowthInput& input_;
  DisparityImage map_;
  cv::Mat1b right_matched_;
  int band_rows_;
  std::vector<Seeds> seeds_;  // of each band
};

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

DisparityImage GrowPlainly(const GrowthRule& rule, const GrowthInput& input,
                           std::span<const Correspondence> seeds) {
  return PlainGrowth(rule, input).Run(seeds);
}

}  // namespace sprout::grow
