#include "common/geometry/widened_frame.h"

#include <gmock/gmock.h>

namespace sprout {
namespace {

using ::testing::ElementsAre;

Seed SeedAt(float u, float u_right) { return {.u = u, .v = 1, .u_right = u_right}; }

TEST(ColumnsBelowZero, AreWhatTheFarthestPointNeeds) {
  EXPECT_EQ(ColumnsBelowZero({.cx = 50, .cx_right = 50}), 0);
  EXPECT_EQ(ColumnsBelowZero({.cx = 50, .cx_right = 40}), 0);
  EXPECT_EQ(ColumnsBelowZero({.cx = 50, .cx_right = 56}), 6);
  EXPECT_EQ(ColumnsBelowZero({.cx = 50, .cx_right = 56.2}), 7);
  EXPECT_GT(ColumnsBelowZero({.cx = 50, .cx_right = 1e9}), kMaxColumns);
}

TEST(ColumnsBelowZero, OfSeedsLeaveRoundingAlone) {
  const std::vector<Seed> rounded = {SeedAt(10, 10.5F), SeedAt(20, 10)};
  EXPECT_EQ(ColumnsBelowZero(rounded), 0);
  const std::vector<Seed> negative = {SeedAt(10, 15.5F), SeedAt(20, 10)};
  EXPECT_EQ(ColumnsBelowZero(negative), 10);
}

TEST(WidenedFrame, AddsToEveryDisparityAndIsCutBack) {
  constexpr int kColumns = 3;
  Frame frame;
  frame.left = (cv::Mat1b(1, 4) << 1, 2, 3, 4);
  frame.right = (cv::Mat1b(1, 4) << 5, 6, 7, 8);
  frame.rig = Rig();
  frame.rig->pair = {
      .width = 4, .height = 1, .focal_px = 10, .cx = 1, .cx_right = 4, .baseline_m = 1};
  frame.seeds = SeedSet{.seeds = {SeedAt(2, 3)}, .raw = 1};
  frame.prior = PriorMap({4, 1});
  frame.prior->disparity.counts()(0, 2) = ToCounts(-1);
  frame.prior->sigma(0, 2) = 7;

  const Frame wide = Widened(frame, kColumns);
  EXPECT_THAT(cv::Mat1b(wide.left), ElementsAre(1, 1, 1, 1, 2, 3, 4));
  EXPECT_THAT(cv::Mat1b(wide.right), ElementsAre(5, 6, 7, 8, 8, 8, 8));
  EXPECT_EQ(wide.rig->pair.width, 7);
  // The same depths.
  EXPECT_EQ(wide.rig->pair.DepthFromDisparity(-1 + kColumns),
            frame.rig->pair.DepthFromDisparity(-1));
  EXPECT_EQ(wide.seeds->seeds[0].disparity(), 2);
  EXPECT_EQ(wide.prior->disparity.Px(5, 0), 2);
  EXPECT_EQ(wide.prior->disparity.CountValid(), 1);

  StageResult result;
  result.outputs.push_back({Part::kPrior, *wide.prior});
  SeedSet seeds = *wide.seeds;
  seeds.seeds.push_back(SeedAt(2, 0));  // left of the left image
  seeds.seeds.push_back(SeedAt(6, 5));  // right of the right one
  seeds.raw = 3;
  result.outputs.push_back({Part::kSeeds, seeds});
  result.outputs.push_back({Part::kLeftSeeds, seeds});
  result.outputs.push_back({Part::kDisparity, wide.prior->disparity});
  result.outputs.push_back({Part::kConfidence, cv::Mat(wide.left)});
  Narrow(result, kColumns, frame.left.size());
  const auto& prior = std::get<PriorMap>(result.outputs[0].value);
  EXPECT_EQ(prior.disparity.Px(2, 0), -1);
  EXPECT_EQ(prior.sigma(0, 2), 7);
  EXPECT_EQ(std::get<SeedSet>(result.outputs[1].value).seeds, frame.seeds->seeds);
  EXPECT_EQ(std::get<SeedSet>(result.outputs[1].value).outside, 2);
  EXPECT_EQ(std::get<SeedSet>(result.outputs[2].value).outside, 1);
  EXPECT_EQ(std::get<DisparityImage>(result.outputs[3].value).Px(2, 0), -1);
  EXPECT_THAT(cv::Mat1b(std::get<cv::Mat>(result.outputs[4].value)), ElementsAre(1, 2, 3, 4));
}

}  // namespace
}  // namespace sprout
