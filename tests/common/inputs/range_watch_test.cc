#include "common/inputs/range_watch.h"

#include <gmock/gmock.h>

namespace sprout::inputs {
namespace {

using testing::HasSubstr;

const TofImage kImage{cv::Mat1f(2, 2, 1.0F), {}};

SeedSet SeedsOf(int raw, int outside, int seeds) {
  return {.seeds = std::vector<Seed>(static_cast<size_t>(seeds)), .raw = raw, .outside = outside};
}

// What is said of so many frames without a range image.
std::string SaidOfPause(RangeWatch& watch, int frames) {
  std::string said;
  for (int i = 0; i < frames; ++i) said += watch.Add({}, SeedsOf(0, 0, 0), {});
  return said;
}

TEST(RangeWatch, SaysOnceThatRangeImagesStopToCome) {
  RangeWatch watch;
  EXPECT_EQ(watch.Add(kImage, SeedsOf(4, 0, 4), {}), "");
  EXPECT_EQ(SaidOfPause(watch, 10), "");
  EXPECT_THAT(SaidOfPause(watch, 1), HasSubstr("do not come any more (of 12 frames 1"));
  EXPECT_EQ(SaidOfPause(watch, 100), "");
  EXPECT_EQ(watch.Add(kImage, SeedsOf(4, 0, 4), {}), "");
  EXPECT_EQ(SaidOfPause(watch, 222), "");  // twice the longest pause so far
  EXPECT_THAT(SaidOfPause(watch, 1), HasSubstr("any more"));
}

TEST(RangeWatch, IsSilentAboutASensorThatIsSlowerThanTheCameras) {
  RangeWatch watch;
  for (int i = 0; i < 20; ++i) {
    EXPECT_EQ(watch.Add(kImage, SeedsOf(4, 0, 4), {}), "");
    EXPECT_EQ(SaidOfPause(watch, 5), "");
  }
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
  EXPECT_EQ(SaidOfPause(watch, 20), "");
}

}  // namespace
}  // namespace sprout::inputs
