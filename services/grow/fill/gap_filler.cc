#include "services/grow/fill/gap_filler.h"

#include "common/core/median.h"
#include "common/core/parallel.h"

namespace sprout::grow {
namespace {

// The build asks the compiler to make vectors of the loop along a row.
void FillFrom(const DisparityImage& prior, const DisparityImage& from, DisparityImage& to) {
  ForEachParallel(static_cast<size_t>(from.height()), [&](size_t row) {
    const int v = static_cast<int>(row);
    const int16_t* const counts = from.counts()[v];
    const int16_t* const priors = prior.counts()[v];
    int16_t* const filled = to.counts()[v];
    for (int u = 0; u < from.width(); ++u) {
      const int16_t here = counts[u];
      const int16_t instead = priors[u];
      filled[u] = here == DisparityImage::kInvalid ? instead : here;
    }
  });
}

}  // namespace

DisparityImage GapFiller::Fill(const DisparityImage& map, GrowConfig::Fill fill,
                               const DisparityImage& prior) {
  if (fill == GrowConfig::NONE || map.empty()) return map;
  Renew(filled_, map.size());
  if (fill != GrowConfig::PRIOR) {
    FillByMedian(map, filled_);
    return filled_;
  }
  const bool has_prior = prior.size() == map.size();
  if (has_prior) {
    Renew(other_, map.size());
    FillFrom(prior, map, other_);
  }
  FilterByMedian(has_prior ? other_.counts() : map.counts(), filled_.counts());
  return filled_;
}

}  // namespace sprout::grow
