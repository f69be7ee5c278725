#include "services/refine/stereo/semi_global.h"

#include <limits>

#include "common/core/parallel.h"
#include "services/refine/stereo/best_matches.h"
#include "services/refine/stereo/path_sums.h"

namespace sprout::refine {

const StereoMatches& SemiGlobalMatcher::Match(const cv::Mat1b& left, const cv::Mat1b& right,
                                              const StereoSearch& search) {
  rows_.Set(search);
  const std::vector<uint8_t>& costs = match_costs_.Compute(left, right, search, rows_);
  RunBoth([&] { AddUpPaths(left, search, rows_, costs, 1, sums_[0]); },
          [&] { AddUpPaths(left, search, rows_, costs, -1, sums_[1]); });
  matches_.best.create(left.size());
  matches_.best.setTo(StereoSearch::kNowhere);
  if (search.confirm) {
    matches_.confirmed_px.create(left.size());
    matches_.confirmed_px.setTo(std::numeric_limits<float>::quiet_NaN());
  }
  ForRangesParallel(left.rows, left.rows, [&](const cv::Range& range) {
    BestMatches matches;
    for (int v = range.start; v < range.end; ++v) {
      const cv::Range& columns = rows_.columns(v);
      const size_t begin = rows_.IndexOf(v, columns.start) * static_cast<size_t>(search.labels);
      matches.Choose(search, v, columns, sums_[0].data() + begin, sums_[1].data() + begin,
                     matches_.best[v], search.confirm ? matches_.confirmed_px[v] : nullptr);
    }
  });
  return matches_;
}

}  // namespace sprout::refine
