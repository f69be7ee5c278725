#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "services/snapshot/snapshot.h"

namespace sprout::snapshot {
namespace {

using ::testing::ContainsRegex;
using ::testing::HasSubstr;

Frame SmallFrame() {
  const cv::Size size(16, 8);
  Frame frame;
  frame.left = cv::Mat1b(size, uchar{90});
  frame.seeds = SeedSet{.seeds = {{3, 3, 1}, {5, 3, 1, 0.5F, SeedOrigin::kStereo}},
                        .raw = 9,
                        .dark = 3,
                        .contradicted = 5};
  frame.prior = PriorMap(size);
  frame.unfilled = DisparityImage(size);
  frame.disparity = DisparityImage(size);
  return frame;
}

StageStatus StatusOf(const std::string& stage, float tof_coverage) {
  StageStatus status;
  status.stage = stage;
  status.tof_coverage = tof_coverage;
  return status;
}

TEST(Report, SaysHowMuchOfTheImageToFSeedsCoverAccordingToEachStage) {
  const std::string text = ReportText(SmallFrame(),
                                      {{"capture", StatusOf("capture", kUnknownCoverage)},
                                       {"refine", StatusOf("refine", 0.625F)},
                                       {"grow", StatusOf("grow", 0)}},
                                      {})
                               .value();
  EXPECT_THAT(text, HasSubstr("ToF %\n"));
  EXPECT_THAT(text, ContainsRegex("capture [^\n]* -\n"));
  EXPECT_THAT(text, ContainsRegex("refine [^\n]* 62.5\n"));
  EXPECT_THAT(text, ContainsRegex("grow [^\n]* 0.0\n"));
}

TEST(Report, TellsToFSeedsFromStereoSeeds) {
  EXPECT_THAT(ReportText(SmallFrame(), {}, {}).value(),
              HasSubstr("seeds: 9 ToF points, dropped 0 outside, 3 dark, 0 loose, 0 background, 0 "
                        "hidden, 5 contradicted; 1 kept, 1 from stereo\n"));
}

}  // namespace
}  // namespace sprout::snapshot
