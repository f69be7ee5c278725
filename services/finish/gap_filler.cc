#include "services/finish/gap_filler.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "common/core/median.h"
#include "common/core/parallel.h"
#include "services/finish/gap_medians.h"

namespace sprout::grow {
namespace {

// One pass over blocks of kFillColumns pixels of a row.
// @param active  the blocks that are looked at, of which a pass fills `to`.
// @returns the blocks in which a gap was filled.
cv::Mat1b FillPass(const DisparityImage& from, const cv::Mat1b& active, DisparityImage& to) {
  cv::Mat1b changed(active.size(), uint8_t{0});
  ForEachParallel(static_cast<size_t>(from.height()), [&](size_t row) {
    const int v = static_cast<int>(row);
    FilledPixels pixels;
    for (int block = 0; block < active.cols; ++block) {
      if (active(v, block) == 0) continue;
      const int u = block * kFillColumns;
      changed(v, block) = FillPixels(from, v, u, pixels) ? 1 : 0;
      std::copy_n(pixels.begin(), std::min(kFillColumns, from.width() - u), &to.counts()(v, u));
    }
  });
  return changed;
}

DisparityImage FillFromPrior(const DisparityImage& map, const DisparityImage& prior) {
  cv::Mat1s without_gaps = map.counts();
  if (prior.size() == map.size()) {
    without_gaps = map.counts().clone();
    prior.counts().copyTo(without_gaps, map.counts() == DisparityImage::kInvalid);
  }
  DisparityImage filled{cv::Mat1s(map.size())};
  MedianFilter().Apply(without_gaps, filled.counts());
  return filled;
}

}  // namespace

DisparityImage FillGaps(const DisparityImage& map, GrowConfig::Fill fill,
                        const DisparityImage& prior) {
  if (fill == GrowConfig::NONE || map.empty()) return map;
  if (fill == GrowConfig::PRIOR) return FillFromPrior(map, prior);
  const int across = (map.width() + kFillColumns - 1) / kFillColumns;
  cv::Mat1b active(map.height(), across, uint8_t{1});
  DisparityImage filled{cv::Mat1s(map.size())};
  cv::Mat1b changed = FillPass(map, active, filled);
  if (fill == GrowConfig::ONE_PASS) return filled;
  // Two maps in turn, which differ in the blocks of the last pass only: these are active again.
  DisparityImage other(filled.counts().clone());
  const cv::Mat1b sees_a_block(5, 3, uint8_t{1});  // a window has two rows above and below
  while (cv::countNonZero(changed) > 0) {
    cv::dilate(changed, active, sees_a_block);
    std::swap(filled, other);
    changed = FillPass(other, active, filled);
  }
  return filled;
}

}  // namespace sprout::grow
