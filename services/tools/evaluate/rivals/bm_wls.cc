#include <opencv2/calib3d.hpp>
#include <opencv2/ximgproc/disparity_filter.hpp>

#include "common/core/image.h"
#include "services/tools/evaluate/rivals/padded_pair.h"
#include "services/tools/evaluate/rivals/rival.h"

namespace sprout::evaluate {
namespace {

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

}  // namespace

Rival BmWls() {
  return {.name = "bm-wls",
          .summary = "block matching of both views, then OpenCV's weighted least squares filter",
          .uses_seeds = false,
          .compute = ComputeBmWls};
}

}  // namespace sprout::evaluate
