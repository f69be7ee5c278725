#include "common/inputs/range_watch.h"

#include <gmock/gmock.h>

namespace sprout::inputs {
namespace {

using testing::HasSubstr;

const TofImage kImage{cv::Mat1f(2, 2, 1.0F), {}};

SeedSet SeedsOf(int raw, int outside, int seeds) {
  return {.seeds = std::vector<Seed>(static_cast<size_t>(seeds)), .raw = raw, .outside = outside};
}

TEST(RangeWatch, SaysOnceThatRangeImagesStopToCome) {
  RangeWatch watch;
  EXPECT_EQ(watch.Add(kImage, SeedsOf(4, 0, 4), {}), "");
  EXPECT_THAT(watch.Add({}, SeedsOf(0, 0, 0), {}),
              HasSubstr("do not come any more (of 2 frames 1"));
  EXPECT_EQ(watch.Add({}, SeedsOf(0, 0, 0), {}), "");
  EXPECT_EQ(watch.Add(kImage, SeedsOf(4, 0, 4), {}), "");
  EXPECT_THAT(watch.Add({}, SeedsOf(0, 0, 0), {}), HasSubstr("any more"));
}

TEST(RangeWatch, SaysWhichStepGivesNothing) {
  RangeWatch watch;
  EXPECT_EQ(watch.Add(kImage, SeedsOf(4, 0, 4), {}), "");
  EXPECT_THAT(watch.Add(kImage, SeedsOf(0, 0, 0), {}), HasSubstr("has no return"));
  EXPECT_THAT(watch.Add(kImage, SeedsOf(4, 4, 0), {}), HasSubstr("none of 4 range points falls"));
  EXPECT_THAT(watch.Add(kImage, {.seeds = {}, .raw = 4, .dark = 4}, {}), HasSubstr("4 dark"));
}

TEST(RangeWatch, IsSilentAboutARigWithoutRangeSensor) {
  RangeWatch watch;
  EXPECT_EQ(watch.Add({}, SeedsOf(0, 0, 0), {}), "");
}

}  // namespace
}  // namespace sprout::inputs
