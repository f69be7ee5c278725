#ifndef SPROUT_SERVICES_GROW_GROWER_H_
#define SPROUT_SERVICES_GROW_GROWER_H_

#include <opencv2/core.hpp>
#include <span>

#include "common/config/config.h"
#include "common/core/disparity_image.h"
#include "common/core/result.h"
#include "common/core/seed.h"
#include "services/grow/seed_queue.h"

namespace sprout {

/// Grows correspondences best first from seeds (paper, Alg. 1).
///
/// Ties, where the paper leaves them open: seeds leave the queue by SeedQueue's rule; initial
/// seeds enter it in the order given; neighbours are visited left, right, up, down; of three
/// equally similar disparities d comes before d − 1 before d + 1. Everything is computed in whole
/// numbers, so the same input gives the same bytes on every machine.
class Grower {
 public:
  /// @throws ConfigError when a value is out of range.
  explicit Grower(const GrowConfig& config);

  /// @param left, right  rectified pair, grey, of one size.
  /// @param seeds        initial correspondences; those whose window leaves an image are ignored.
  /// @param prior        D_p, of the images' size; not looked at unless the similarity is EPC.
  /// @returns disparities, one-to-one: rounded to whole pixels, no two left pixels share a right
  ///          pixel. In whole pixels, or with sub_pixel to the counts of DisparityImage. An error
  ///          when sizes differ or the images are smaller than the window.
  /// About one window triple a pixel. Keeps its queue from frame to frame, so one object serves
  /// one thread.
  Result<DisparityImage> Compute(const cv::Mat1b& left, const cv::Mat1b& right,
                                 std::span<const Seed> seeds, const DisparityImage& prior);

 private:
  double SigmaP(std::span<const Seed> seeds, const DisparityImage& prior) const;

  GrowConfig config_;
  SeedQueue queue_;
};

}  // namespace sprout

#endif  // SPROUT_SERVICES_GROW_GROWER_H_
