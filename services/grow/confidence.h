#ifndef SPROUT_SERVICES_GROW_CONFIDENCE_H_
#define SPROUT_SERVICES_GROW_CONFIDENCE_H_

#include <opencv2/core.hpp>
#include <span>

#include "common/core/disparity_image.h"
#include "common/core/seed.h"

namespace sprout {

/// How far a map's disparities can be trusted, from what goes wrong in practice: depth edges that
/// are some pixels off, pixels that growth did not reach, windows that do not fit, and holes
/// between the seeds, which the prior closes as well as it can.
///
///   confidence = 255 · (1 − 0.45·exp(−r / 8) − 0.15·g − 0.15·min(e / 5, 1) − 0.25·h)
///
/// r: distance to the next depth edge (more than 1 px within 3×3 pixels), px;
/// g: share of the 9×9 window that growth left empty;
/// e: exponent of eq. (4) between the 5×5 window and what the disparities make of the right image;
/// h: how far the next seed is, in spacings of seeds spread evenly over the image: 0 up to 0.75,
///    which a square grid does not exceed, and 1 from 1.75 on. What only the left camera sees is a
///    hole, too: there is no correspondence.
/// The weights are fixed: with others for the first three, errors come in nearly the same order.
///
/// @param left, right      rectified pair, grey, of the maps' size.
/// @param seeds            correspondences that growth started from.
/// @param grown            map before gap filling.
/// @param filled           map after gap filling, which is judged.
/// @param sigma_s_squared  σ_s² of eq. (4).
/// @returns 0 (least) to 255 for each pixel of the left image; 0 where `filled` has no disparity.
///          Sorting by it is what it is made for; it is no probability. O(pixels).
cv::Mat1b Confidence(const cv::Mat1b& left, const cv::Mat1b& right, std::span<const Seed> seeds,
                     const DisparityImage& grown, const DisparityImage& filled,
                     double sigma_s_squared);

/// Takes the disparities away whose confidence is below a bound: unknown stays unknown.
/// @param least  0 (all stay) to 255. O(pixels).
void DropUnsure(const cv::Mat1b& confidence, int least, DisparityImage& disparity);

/// Confidence() for frame after frame: keeps its memory (some 35 bytes a pixel), and gives a map
/// that nobody else holds any more out again; in steady state only OpenCV's filters allocate. Works
/// on OpenCV's threads, with the same result for any number. One object serves one caller at a
/// time.
class ConfidenceJudge {
 public:
  cv::Mat1b Judge(const cv::Mat1b& left, const cv::Mat1b& right, std::span<const Seed> seeds,
                  const DisparityImage& grown, const DisparityImage& filled,
                  double sigma_s_squared);

 private:
  void MeasureEdges(const DisparityImage& filled);
  void MeasureHoles(std::span<const Seed> seeds, cv::Size size);
  void CountGaps(const DisparityImage& grown);
  void Compare(const cv::Mat1b& left, const cv::Mat1b& right, const DisparityImage& filled);

  cv::Mat1s most_, least_, range_;  // of the disparities around each pixel
  cv::Mat1b even_;
  cv::Mat1f edge_px_;  // distance to the next depth edge
  cv::Mat1b no_seed_;
  cv::Mat1f seed_px_;  // distance to the next seed
  float spacing_px_ = 0;
  cv::Mat1b gap_;
  cv::Mat1i gaps_;  // number of pixels in the window that have no disparity
  cv::Mat1b warped_, off_;
  cv::Mat1i difference_;  // Σ (wL − wR)² around every pixel
  cv::Mat1i energy_;      // Σ (wL² + wR²)
  cv::Mat1i warped_energy_;
  cv::Mat1b result_;
};

}  // namespace sprout

#endif  // SPROUT_SERVICES_GROW_CONFIDENCE_H_
