#pragma once

#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "common/config/config.h"
#include "common/core/disparity_image.h"
#include "common/core/prior_map.h"
#include "common/core/result.h"
#include "common/core/seed.h"
#include "services/grow/paper/growth_rule.h"
#include "services/grow/sweep/growth_band.h"
#include "services/grow/sweep/segments.h"
#include "services/grow/sweep/sweep_band.h"

namespace sprout::grow {

/// Grows correspondences from seeds: for EPC with kernels for each instruction set, otherwise with
/// plain_growth.h, which gives the same.
///
/// Pixels to which the prior leaves up to 15 disparities are matched in sweeps over the rows
/// (README, SweepPlainly()), then the others best first, from the seeds and from what has been
/// swept (paper, Alg. 1). Where all are open, as with preset paper, nothing is swept.
///
/// Where the paper leaves a choice: seeds leave the queue by level (GrowthRule::LevelOf()), within
/// a level the last one added first; initial seeds enter it in the order given; neighbours are
/// visited left, right, up, down; of equally similar disparities d comes before d − 1 before d + 1.
///
/// The image is cut into bands of RowsPerBand() rows. Each grows from its own seeds; when all are
/// finished, each grows on from the pixels of its neighbours' border rows, and so on until nothing
/// changes. So the bands can grow at the same time, on OpenCV's threads (cv::setNumThreads), and
/// the same input gives the same bytes on every machine, with any number of threads and any
/// instruction set. A sweep does not depend on the bands.
class Grower {
 public:
  /// @throws ConfigError when a value is out of range.
  explicit Grower(const GrowConfig& config);

  /// @param left, right  rectified pair, grey, of one size.
  /// @param seeds        initial correspondences; those whose window leaves an image are ignored.
  /// @param prior        D_p, of the images' size; used only if the similarity is EPC. Its standard
  ///                     deviation says how far a pixel is searched, see SigmaP().
  /// @returns disparities, one-to-one: rounded to whole pixels, no two left pixels share a right
  ///          pixel. In whole pixels, or with sub_pixel to the counts of DisparityImage. An error
  ///          when sizes differ or the images are smaller than the window.
  /// EPC: 8 to 40 ns a pixel. Up to 13 bytes a pixel are kept from frame to frame, and the result
  /// as long as nobody else holds it, so one object serves one caller at a time. Otherwise 0.3 µs.
  Result<DisparityImage> Compute(const cv::Mat1b& left, const cv::Mat1b& right,
                                 std::span<const Seed> seeds, const PriorMap& prior);

 private:
  void CutIntoBands(int height);
  void Sweep(SweepFunction sweep, const GrowthInput& input, std::span<const Correspondence> seeds);
  void GrowOpen(const GrowthKernel& kernel, const GrowthInput& input,
                std::span<const Correspondence> seeds);

  GrowthRule rule_;
  SeedsByRow seeds_by_row_;
  std::vector<SweepBand> sweeps_;
  std::vector<GrowthBand> bands_;  // of those with open pixels
  DisparityImage map_;
};

}  // namespace sprout::grow
