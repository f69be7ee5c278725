#include "services/pipeline/files/believe_nothing.h"

#include <gmock/gmock.h>

#include <cmath>

#include "common/core/prior_map.h"

namespace sprout {
namespace {

DepthFrame FrameOfFour() {
  DepthFrame depth;
  depth.disparity = DisparityImage(cv::Mat1s(1, 4, ToCounts(20)));
  depth.confidence = cv::Mat1b(1, 4, uint8_t{200});
  depth.sigma = cv::Mat1b(1, 4, uint8_t{4});
  depth.kept = DisparityImage(cv::Mat1s(depth.disparity.counts().clone()));
  depth.depth_m = cv::Mat1f(1, 4, 2.0F);
  return depth;
}

TEST(BelieveNothing, IsSaidOfEveryPixel) {
  DepthFrame depth = FrameOfFour();
  BelieveNothing(LoadConfig({"default"}), depth);
  EXPECT_EQ(cv::countNonZero(depth.confidence), 0);
  EXPECT_EQ(cv::countNonZero(depth.sigma == kMaxSigmaCounts), 4);
  EXPECT_TRUE(depth.disparity.IsValid(0, 0));
  EXPECT_EQ(depth.depth_m(0, 0), 2);
}

TEST(BelieveNothing, LeavesOutWhatIsLessSureThanAsked) {
  DepthFrame depth = FrameOfFour();
  BelieveNothing(LoadConfig({"default", "grow { min_confidence: 90 }"}), depth);
  EXPECT_FALSE(depth.disparity.AnyValid());
  EXPECT_TRUE(std::isnan(depth.depth_m(0, 3)));
  depth = FrameOfFour();
  BelieveNothing(LoadConfig({"default", "depth { min_confidence: 110 }"}), depth);
  EXPECT_TRUE(depth.disparity.IsValid(0, 0));
  EXPECT_FALSE(depth.kept.AnyValid());
  EXPECT_TRUE(std::isnan(depth.depth_m(0, 3)));
}

TEST(BelieveNothing, NeedsNoConfidence) {
  DepthFrame depth = FrameOfFour();
  depth.confidence.release();
  depth.sigma.release();
  BelieveNothing(LoadConfig({"fast"}), depth);
  EXPECT_TRUE(depth.confidence.empty());
  EXPECT_TRUE(depth.disparity.IsValid(0, 0));
}

}  // namespace
}  // namespace sprout
