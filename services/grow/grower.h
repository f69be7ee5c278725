#ifndef SPROUT_SERVICES_GROW_GROWER_H_
#define SPROUT_SERVICES_GROW_GROWER_H_

#include <cstdint>
#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "common/config/config.h"
#include "common/core/disparity_image.h"
#include "common/core/prior_map.h"
#include "common/core/result.h"
#include "common/core/seed.h"
#include "services/grow/growth_band.h"

namespace sprout {

/// Grows correspondences best first from seeds (paper, Alg. 1).
///
/// Ties, where the paper leaves them open: seeds leave the queue by SeedQueue's rule; initial
/// seeds enter it in the order given; neighbours are visited left, right, up, down; of three
/// equally similar disparities d comes before d − 1 before d + 1.
///
/// The image is cut into bands of GrowthBand::RowsPerBand() rows. Each grows from its own seeds;
/// when all have come to rest, each grows on from the pixels of its neighbours' border rows, and so
/// on until nothing changes. So the bands can grow at the same time, on OpenCV's threads
/// (cv::setNumThreads), and the same input gives the same bytes on every machine, with any number
/// of threads and any instruction set.
class Grower {
 public:
  /// @throws ConfigError when a value is out of range.
  explicit Grower(const GrowConfig& config);

  /// @param left, right  rectified pair, grey, of one size.
  /// @param seeds        initial correspondences; those whose window leaves an image are ignored.
  /// @param prior        D_p, of the images' size; not looked at unless the similarity is EPC. Its
  ///                     standard deviation says how far a pixel is searched, see SigmaP().
  /// @returns disparities, one-to-one: rounded to whole pixels, no two left pixels share a right
  ///          pixel. In whole pixels, or with sub_pixel to the counts of DisparityImage. An error
  ///          when sizes differ or the images are smaller than the window.
  /// About one window triple a pixel. Keeps its memory (scratch_bytes()) from frame to frame, so
  /// one object serves one caller at a time; a map that nobody else holds any more is used again.
  Result<DisparityImage> Compute(const cv::Mat1b& left, const cv::Mat1b& right,
                                 std::span<const Seed> seeds, const PriorMap& prior);

  /// Memory kept from frame to frame without the map, bytes.
  size_t scratch_bytes() const;

 private:
  void PrepareScratch(cv::Size size, const PriorMap& prior);
  void DistributeSeeds(std::span<const Seed> seeds, cv::Size size);
  void GrowBands(const GrowthInput& input);

  GrowConfig config_;
  GrowthRule rule_;
  std::vector<GrowthBand> bands_;
  std::vector<GrowthSeed> rounded_seeds_;  // in the order given
  std::vector<GrowthSeed> seeds_;          // by bands
  std::vector<size_t> seeds_end_;          // of each band
  std::vector<int16_t> seams_;
  DisparityImage map_;
};

}  // namespace sprout

#endif  // SPROUT_SERVICES_GROW_GROWER_H_
