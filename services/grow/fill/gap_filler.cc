#include "services/grow/fill/gap_filler.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "common/core/median.h"
#include "common/core/parallel.h"
#include "services/grow/fill/gap_medians.h"

namespace sprout::grow {
namespace {

// Every gap takes the median of its window in the map as it was.
void FillFromWindows(const DisparityImage& from, DisparityImage& to) {
  ForEachParallel(static_cast<size_t>(from.height()), [&](size_t row) {
    const int v = static_cast<int>(row);
    FilledPixels pixels;
    for (int u = 0; u < from.width(); u += kFillColumns) {
      FillPixels(from, v, u, pixels);
      std::copy_n(pixels.begin(), std::min(kFillColumns, from.width() - u), &to.counts()(v, u));
    }
  });
}

}  // namespace

DisparityImage GapFiller::Fill(const DisparityImage& map, GrowConfig::Fill fill,
                               const DisparityImage& prior) {
  if (fill == GrowConfig::NONE || map.empty()) return map;
  Renew(filled_, map.size());
  if (fill == GrowConfig::PRIOR) {
    FillFromPrior(map, prior);
  } else {
    FillFromWindows(map, filled_);
  }
  return filled_;
}

void GapFiller::FillFromPrior(const DisparityImage& map, const DisparityImage& prior) {
  const bool has_prior = prior.size() == map.size();
  if (has_prior) {
    map.counts().copyTo(other_.counts());
    cv::compare(map.counts(), DisparityImage::kInvalid, is_gap_, cv::CMP_EQ);
    prior.counts().copyTo(other_.counts(), is_gap_);
  }
  MedianFilter().Apply(has_prior ? other_.counts() : map.counts(), filled_.counts());
}

}  // namespace sprout::grow
