#ifndef SPROUT_SERVICES_GROW_CONFIDENCE_H_
#define SPROUT_SERVICES_GROW_CONFIDENCE_H_

#include <opencv2/core.hpp>
#include <span>

#include "common/core/disparity_image.h"
#include "common/core/seed.h"
#include "services/grow/confidence_kernel.h"

namespace sprout::grow {

/// How far a map's disparities can be trusted, by the usual causes of errors: depth edges that are
/// some pixels off, pixels that growth did not reach, windows that do not match, and holes between
/// the seeds, which only the prior fills.
///
///   confidence = 255 · (1 − 0.45·exp(−r / 8) − 0.15·g − 0.15·min(e / 5, 1) − 0.25·h)      (C1)
///
/// r: distance to the next depth edge (more than 1 px within 3×3 pixels), px;
/// g: share of the 9×9 window that growth left empty;
/// e: exponent of eq. (4) between the 5×5 windows of the left image and of the right image warped
/// by the disparities; h: how far the next seed is, in spacings of seeds spread evenly over the
/// image: 0 up to 0.75,
///    which a square grid does not exceed (its pixels are up to √½ = 0.71 away), and 1 from 1.75
///    on. A region that only the left camera sees is a hole, too: it has no correspondence.
/// The weights add up to 1. They are fixed: with others for the first three, errors come in nearly
/// the same order.
///
class ConfidenceEstimator {
 public:
  /// @param sigma_s_squared  σ_s² of eq. (4).
  explicit ConfidenceEstimator(double sigma_s_squared)
      : photo_scale_(static_cast<float>(1 / sigma_s_squared)) {}

  /// @param left, right  rectified pair, grey, of the maps' size.
  /// @param seeds        correspondences that growth started from.
  /// @param grown        map before gap filling.
  /// @param filled       map after gap filling, which is judged.
  /// @returns 0 (least) to 255 for each pixel of the left image; 0 where `filled` has no disparity.
  ///          Sorting by it is what it is made for; it is no probability. O(pixels), on OpenCV's
  ///          threads with the same result for any number. Keeps 6 bytes a pixel from frame to
  ///          frame, so one object serves one caller at a time.
  cv::Mat1b Compute(const cv::Mat1b& left, const cv::Mat1b& right, std::span<const Seed> seeds,
                    const DisparityImage& grown, const DisparityImage& filled);

 private:
  // @returns the spacing of that many seeds if spread evenly, px.
  float MarkSeeds(std::span<const Seed> seeds, cv::Size size);

  float photo_scale_;
  cv::Mat1b no_seed_;  // 0 at seeds
  DistanceMemory edge_memory_, hole_memory_;
  cv::Mat1w edge_penalties_, hole_penalties_;
  cv::Mat1b confidence_;
};

/// Removes the disparities whose confidence is below a bound. Pixels without a disparity stay so.
/// @param least  0 (all stay) to 255. O(pixels).
void DropUnsure(const cv::Mat1b& confidence, int least, DisparityImage& disparity);

}  // namespace sprout::grow

#endif  // SPROUT_SERVICES_GROW_CONFIDENCE_H_
