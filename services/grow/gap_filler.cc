#include "services/grow/gap_filler.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "common/core/median.h"
#include "common/core/parallel.h"
#include "services/grow/gap_medians.h"

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

}  // namespace

DisparityImage GapFiller::Fill(const DisparityImage& map, GrowConfig::Fill fill,
                               const DisparityImage& prior) {
  if (fill == GrowConfig::NONE || map.empty()) return map;
  Renew(filled_, map.size());
  if (fill == GrowConfig::PRIOR) {
    FillFromPrior(map, prior);
  } else {
    FillFromWindows(map, fill == GrowConfig::UNTIL_STABLE);
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

void GapFiller::FillFromWindows(const DisparityImage& map, bool until_stable) {
  const int across = (map.width() + kFillColumns - 1) / kFillColumns;
  cv::Mat1b active(map.height(), across, uint8_t{1});
  cv::Mat1b changed = FillPass(map, active, filled_);
  if (!until_stable) return;
  // Two maps in turn, which differ in the blocks of the last pass only: these are active again.
  Renew(other_, map.size());
  filled_.counts().copyTo(other_.counts());
  const cv::Mat1b sees_a_block(5, 3, uint8_t{1});  // a window has two rows above and below
  while (cv::countNonZero(changed) > 0) {
    cv::dilate(changed, active, sees_a_block);
    std::swap(filled_, other_);
    changed = FillPass(other_, active, filled_);
  }
}

}  // namespace sprout::grow
