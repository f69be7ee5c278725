#include "services/grow/paper/plain_growth.h"

#include <algorithm>
#include <queue>
#include <vector>

#include "common/core/parallel.h"
#include "services/grow/paper/plain_costs.h"

namespace sprout::grow {
namespace {

class PlainGrowth {
 public:
  PlainGrowth(const GrowthRule& rule, const GrowthInput& input)
      : rule_(rule),
        input_(input),
        map_(input.left.size()),  // Step 3
        right_matched_(input.right.size(), uint8_t{0}),
        band_rows_(RowsPerBand(input.left.rows)),
        seeds_(static_cast<size_t>(CountBands(input.left.rows))) {}

  // Alg. 1 in each band of rows, and from band to band until none grows any more.
  // @param swept  the pixels that are not open.
  DisparityImage Run(std::span<const Correspondence> seeds, const DisparityImage& swept) {
    TakeOver(swept);
    for (const Correspondence& s : seeds) AddSeed(s, CostOf(rule_, input_, s));  // Step 2
    ForEachParallel(seeds_.size(), [&](size_t band) {
      StartBesideSwept(band);
      Grow(seeds_[band]);
    });
    for (bool changed = true; changed;) {
      const cv::Mat1s before = map_.counts().clone();
      ForEachParallel(seeds_.size(), [&](size_t band) {
        const cv::Range rows = RowsOf(band);
        CrossFrom(before, rows.start - 1, rows.start);
        CrossFrom(before, rows.end, rows.end - 1);
        Grow(seeds_[band]);
      });
      changed = cv::countNonZero(before != map_.counts()) > 0;
    }
    return WithSubPixelSteps(swept);
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
  cv::Range RowsOf(size_t band) const {
    const int top = static_cast<int>(band) * band_rows_;
    return {top, std::min(top + band_rows_, map_.height())};
  }

  bool IsOpen(int u, int v) const {
    return rule_.min_open_sigma == 0 || rule_.IsOpen(input_.prior.sigma(v, u));
  }

  // Puts the swept pixels into the map, in whole disparities; their right pixels are matched.
  void TakeOver(const DisparityImage& swept) {
    for (int v = 0; v < map_.height(); ++v) {
      for (int u = 0; u < map_.width(); ++u) {
        if (!swept.IsValid(u, v)) continue;
        const int d = WholeDisparity(swept.counts()(v, u));
        map_.counts()(v, u) = static_cast<int16_t>(d * DisparityImage::kCountsPerPixel);
        right_matched_(v, u - d) = 1;
      }
    }
  }

  // Visits open pixels from the matched pixels around them, row by row.
  void StartBesideSwept(size_t band) {
    const cv::Range rows = RowsOf(band);
    for (int v = rows.start; v < rows.end; ++v) {
      for (int u = 0; u < map_.width(); ++u) {
        for (const cv::Point from : {cv::Point(u - 1, v), {u + 1, v}, {u, v - 1}, {u, v + 1}}) {
          if (from.x < 0 || from.x >= map_.width() || from.y < rows.start || from.y >= rows.end ||
              !map_.IsValid(from.x, from.y)) {
            continue;
          }
          Visit({u, v, map_.counts()(from) / DisparityImage::kCountsPerPixel});
        }
      }
    }
  }

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

  // Steps 6 and 7: the best of three disparities and its cost; of equals d comes before d − 1
  // before d + 1.
  void Visit(const Correspondence& near) {
    if (!cv::Rect({}, map_.size()).contains({near.u, near.v}) || !IsOpen(near.u, near.v)) return;
    Correspondence best = near;
    int32_t best_cost = kExcludedCost;
    for (const int step : {0, -1, 1}) {
      const Correspondence q{near.u, near.v, near.d + step};
      const int32_t cost = CostWhereItFits(rule_, input_, q);
      if (cost < best_cost) {
        best = q;
        best_cost = cost;
      }
    }
    if (best_cost > rule_.limit) return;  // Step 8
    if (map_.IsValid(best.u, best.v)) return;
    uint8_t& right_matched = right_matched_(best.v, best.u - best.d);
    if (right_matched != 0) return;
    AddSeed(best, best_cost);        // Step 9
    map_.counts()(best.v, best.u) =  // Step 10
        static_cast<int16_t>(best.d * DisparityImage::kCountsPerPixel);
    right_matched = 1;
  }

  // Grows from a neighbouring band's border row, as the last round left it, from left to right.
  void CrossFrom(const cv::Mat1s& before, int from, int to) {
    if (from < 0 || from >= before.rows) return;
    for (int u = 0; u < before.cols; ++u) {
      const int16_t counts = before(from, u);
      if (counts == DisparityImage::kInvalid) continue;
      Visit({u, to, counts / DisparityImage::kCountsPerPixel});
    }
  }

  DisparityImage WithSubPixelSteps(const DisparityImage& swept) const {
    if (!rule_.sub_pixel) return map_;
    DisparityImage moved(map_.counts().clone());
    swept.counts().copyTo(moved.counts(), swept.counts() != DisparityImage::kInvalid);  // have them
    for (int v = 0; v < map_.height(); ++v) {
      for (int u = 0; u < map_.width(); ++u) {
        if (!map_.IsValid(u, v) || swept.IsValid(u, v)) continue;
        const int d = map_.counts()(v, u) / DisparityImage::kCountsPerPixel;
        moved.counts()(v, u) += static_cast<int16_t>(SubPixelStep(rule_, input_, {u, v, d}));
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

DisparityImage GrowPlainly(const GrowthRule& rule, const GrowthInput& input,
                           std::span<const Correspondence> seeds) {
  return PlainGrowth(rule, input).Run(seeds, SweepPlainly(rule, input, seeds));
}

}  // namespace sprout::grow
