#include <opencv2/calib3d.hpp>
#include <opencv2/ximgproc/disparity_filter.hpp>

#include "common/core/image.h"
#include "services/evaluate/rivals/padded_pair.h"
#include "services/evaluate/rivals/rival.h"

namespace sprout {
namespace {

// As OpenCV's own example: both views matched, then weighted least squares with their agreement as
// confidence.
cv::Mat1f Compute(const RivalInput& input) {
  constexpr int kBlock = 21;
  constexpr double kLambda = 8000;
  constexpr double kSigmaColor = 1.5;
  const PaddedPair pair(ToGrey(input.left), ToGrey(input.right), input.max_disparity_px);
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
  filter->filter(left_map, pair.left(), filtered, right_map, {}, pair.right());
  return pair.Crop(filtered);
}

}  // namespace

Rival BmWls() {
  return {.name = "bm-wls",
          .summary = "the same in both views, then OpenCV's weighted least squares filter",
          .uses_seeds = false,
          .compute = Compute};
}

}  // namespace sprout
