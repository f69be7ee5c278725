#include <opencv2/calib3d.hpp>
#include <opencv2/ximgproc/disparity_filter.hpp>
#include <opencv2/ximgproc/edge_filter.hpp>

#include "common/core/image.h"
#include "services/tools/evaluate/rivals/padded_pair.h"
#include "services/tools/evaluate/rivals/rival.h"

namespace sprout::evaluate {
namespace {

// OpenCV's defaults, which drop what is not unique or has no texture.
cv::Mat1f ComputeBm(const RivalInput& input) {
  constexpr int kBlock = 21;
  const PaddedPair pair(ToGrey(input.left), ToGrey(input.right), input.max_disparity_px, kBlock);
  return MatchPadded(*cv::StereoBM::create(pair.disparities(), kBlock), pair);
}

// The method of OpenCV's own example: both views are matched, then filtered by weighted least
// squares with their agreement as confidence. Block, lambda and sigma are the best of 15, 21 × 200
// ... 8000 × 0.8, 1.5 on scenes of half and third size; the example's own 8000 and 1.5 make it
// worse than without the filter.
cv::Mat1f ComputeBmWls(const RivalInput& input) {
  constexpr int kBlock = 15;
  constexpr double kLambda = 200;
  constexpr double kSigmaColor = 0.8;
  const PaddedPair pair(ToGrey(input.left), ToGrey(input.right), input.max_disparity_px, kBlock,
                        PaddedPair::Views::kBoth);
  const auto matcher = cv::StereoBM::create(pair.disparities(), kBlock);
  const auto filter = cv::ximgproc::createDisparityWLSFilter(matcher);  // sets the matcher up
  const auto right_matcher = cv::ximgproc::createRightMatcher(matcher);
  cv::Mat1s left_map;
  cv::Mat1s right_map;
  matcher->compute(pair.left(), pair.right(), left_map);
  right_matcher->compute(pair.right(), pair.left(), right_map);

  filter->setLambda(kLambda);
  filter->setSigmaColor(kSigmaColor);
  cv::Mat1s filtered;
  filter->filter(left_map, pair.Pad(input.left), filtered, right_map, {}, pair.right());
  return pair.Crop(filtered);
}

// Min et al., "Fast Global Image Smoothing Based on Weighted Least Squares", TIP 2014, IV-B:
// smoothed disparities over smoothed weights, an average of the seeds that no edge of the image
// separates from the pixel. A pixel that no seed reaches is NaN: 0 / 0.
cv::Mat1f ComputeFgs(const RivalInput& input) {
  cv::Mat1f disparity_px(input.left.size(), 0.F);
  cv::Mat1f weight(input.left.size(), 0.F);
  for (const Seed& seed : input.seeds) {
    const cv::Point pixel(cvRound(seed.u), cvRound(seed.v));
    if (!cv::Rect({}, input.left.size()).contains(pixel)) continue;
    disparity_px(pixel) = seed.disparity();
    weight(pixel) = 1;
  }
  const auto smoother =
      cv::ximgproc::createFastGlobalSmootherFilter(input.left, input.fgs.lambda, input.fgs.sigma);
  cv::Mat1f spread_px;
  cv::Mat1f spread_weight;
  smoother->filter(disparity_px, spread_px);
  smoother->filter(weight, spread_weight);
  cv::divide(spread_px, spread_weight, spread_px);
  return spread_px;
}

// Parameters as OpenCV's documentation advises: penalties of 8 and 32 times the block's area.
cv::Mat1f Sgbm(const RivalInput& input, int mode) {
  constexpr int kBlock = 5;
  constexpr int kFirstDisparity = 0;
  constexpr int kSmallStepPenalty = 8 * kBlock * kBlock;
  constexpr int kLargeStepPenalty = 32 * kBlock * kBlock;
  constexpr int kLeftRightTolerance = 1;  // px
  constexpr int kPreFilterCap = 63;
  constexpr int kUniquenessPercent = 10;
  constexpr int kSpeckleArea = 100;  // px
  constexpr int kSpeckleRange = 2;   // px
  const PaddedPair pair(ToGrey(input.left), ToGrey(input.right), input.max_disparity_px, kBlock);
  return MatchPadded(
      *cv::StereoSGBM::create(kFirstDisparity, pair.disparities(), kBlock, kSmallStepPenalty,
                              kLargeStepPenalty, kLeftRightTolerance, kPreFilterCap,
                              kUniquenessPercent, kSpeckleArea, kSpeckleRange, mode),
      pair);
}

cv::Mat1f Compute3Way(const RivalInput& input) {
  return Sgbm(input, cv::StereoSGBM::MODE_SGBM_3WAY);
}

cv::Mat1f Compute5Way(const RivalInput& input) { return Sgbm(input, cv::StereoSGBM::MODE_SGBM); }

}  // namespace

std::vector<Rival> AllRivals() {
  return {{.name = "sgbm-3way",
           .summary = "OpenCV's semi-global matching along 3 directions",
           .uses_seeds = false,
           .compute = Compute3Way},
          {.name = "sgbm-5way",
           .summary = "OpenCV's semi-global matching along 5 directions",
           .uses_seeds = false,
           .compute = Compute5Way},
          {.name = "bm",
           .summary = "OpenCV's block matching, blocks of 21 px",
           .uses_seeds = false,
           .compute = ComputeBm},
          {.name = "bm-wls",
           .summary = "block matching of both views, then OpenCV's weighted least squares filter",
           .uses_seeds = false,
           .compute = ComputeBmWls},
          {.name = "fgs",
           .summary = "OpenCV's FastGlobalSmoother spreads the ToF seeds over the left image, with "
                      "--fgs-lambda and --fgs-sigma; never looks at the right one",
           .uses_seeds = true,
           .compute = ComputeFgs}};
}

}  // namespace sprout::evaluate
