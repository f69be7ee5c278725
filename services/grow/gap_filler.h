#ifndef SPROUT_SERVICES_GROW_GAP_FILLER_H_
#define SPROUT_SERVICES_GROW_GAP_FILLER_H_

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "common/config/config.h"
#include "common/core/disparity_image.h"
#include "common/core/median.h"
#include "services/grow/gap_medians.h"

namespace sprout {

/// Gap filling (paper, III): a pixel without disparity takes the median of the valid ones in its
/// 5×5 window (the lower one of two in the middle; the window ends at the image's border).
///
/// @param fill  NONE: returns the map; ONE_PASS: gaps look at the given map only; UNTIL_STABLE:
///              passes until nothing changes, so only an empty map keeps gaps. PRIOR: gaps take
///              the prior's disparity instead, then every pixel the median of its 5×5 window.
/// @param prior  of the map's size; only looked at by PRIOR. An empty one fills nothing.
/// @returns a new map; the given one is not changed. O(pixels).
DisparityImage FillGaps(const DisparityImage& map, GrowConfig::Fill fill,
                        const DisparityImage& prior);

/// FillGaps() for frame after frame: keeps its memory, and gives a map that nobody else holds any
/// more out again; in steady state it allocates nothing. Works on OpenCV's threads. One object
/// serves one caller at a time.
class GapFiller {
 public:
  DisparityImage Fill(const DisparityImage& map, GrowConfig::Fill fill,
                      const DisparityImage& prior);

 private:
  // kFillColumns pixels of a row.
  struct Block {
    int v;
    int column;  // of blocks
  };
  struct Filled {
    FilledPixels pixels;
    bool changed;
  };

  void FillOnce(const DisparityImage& map);
  void FillOn();
  void KeepFilled();
  void ListBlocksAround();
  void FillFromPrior(const DisparityImage& map, const DisparityImage& prior);

  cv::Mat1s without_gaps_;
  MedianFilter median_;
  std::vector<Block> blocks_, next_blocks_;
  std::vector<Filled> filled_;  // of blocks_
  std::vector<uint8_t> listed_;
  DisparityImage result_;
};

}  // namespace sprout

#endif  // SPROUT_SERVICES_GROW_GAP_FILLER_H_
