#include "common/core/frame.h"

#include <gtest/gtest.h>

#include <string>
#include <type_traits>
#include <variant>

namespace sprout {
namespace {

TEST(PartSet, HasExactlyWhatWasAdded) {
  PartSet set{Part::kLeft, Part::kDisparity};
  set.Add(Part::kTof);
  set.Add(Part::kTof);
  for (const Part part : kAllParts) {
    const bool added = part == Part::kLeft || part == Part::kDisparity || part == Part::kTof;
    EXPECT_EQ(set.Has(part), added) << static_cast<int>(part);
  }
  EXPECT_EQ(set, (PartSet{Part::kTof, Part::kDisparity, Part::kLeft}));
  EXPECT_NE(set, (PartSet{Part::kTof, Part::kLeft}));
  EXPECT_EQ(PartSet{}, PartSet());
}

TEST(PartSet, ListsEveryPartOnce) {
  PartSet all;
  for (const Part part : kAllParts) {
    EXPECT_FALSE(all.Has(part));
    all.Add(part);
  }
}

// Which places of a frame are filled, in the order of kAllParts.
std::vector<bool> Filled(const Frame& frame) {
  return {!frame.left.empty(),
          !frame.right.empty(),
          frame.tof.has_value(),
          frame.rig.has_value(),
          frame.seeds.has_value(),
          frame.left_seeds.has_value(),
          frame.prior.has_value(),
          frame.unfilled.has_value(),
          frame.disparity.has_value(),
          !frame.confidence.empty(),
          !frame.sigma.empty(),
          frame.depth.has_value(),
          frame.depth_sigma.has_value(),
          frame.cloud.has_value(),
          frame.fused.has_value(),
          !frame.fused_confidence.empty(),
          frame.motion.has_value(),
          frame.depth_counts.has_value(),
          frame.base_cloud.has_value(),
          frame.target_depth.has_value(),
          frame.target_cloud.has_value(),
          frame.odometry.has_value(),
          frame.tof_zones.has_value()};
}

// What such a member holds.
PartValue ValueFor(Part part) {
  return std::visit(
      []<typename T>(T Frame::*) -> PartValue {
        if constexpr (std::is_same_v<T, cv::Mat>)
          return cv::Mat(2, 3, CV_8UC1, cv::Scalar(9));
        else
          return typename T::value_type();
      },
      RowOf(part).member);
}

TEST(SetPart, FillsThePlaceOfThatPartAndNoOther) {
  for (size_t i = 0; i < kPartCount; ++i) {
    Frame frame;
    SetPart(frame, kAllParts[i], ValueFor(kAllParts[i]));
    std::vector<bool> expected(kPartCount, false);
    expected[i] = true;
    EXPECT_EQ(Filled(frame), expected) << "part " << i;
  }
}

TEST(BytesOf, CountsTheDisparitiesAndHowSureTheyAre) {
  Frame frame;
  EXPECT_EQ(BytesOf(frame), 0U);
  frame.disparity = DisparityImage(cv::Size(3, 2));
  EXPECT_EQ(BytesOf(frame), 12U);
  frame.prior = PriorMap(cv::Size(3, 2));
  EXPECT_EQ(BytesOf(frame), 12U + 18U);
}

TEST(PartOf, IsTheInverseOfChannelOf) {
  for (const Part part : kAllParts) {
    const std::string channel(ChannelOf(part));
    EXPECT_EQ(PartOf(channel), part);
    EXPECT_EQ(PartOf("robot/" + channel, "robot/"), part);
    EXPECT_EQ(PartOf("robot/" + channel), std::nullopt);
    EXPECT_EQ(PartOf(channel, "robot/"), std::nullopt);
    EXPECT_EQ(PartOf(channel + "X"), std::nullopt);
  }
  for (const char* channel : {"", "SPROUT_STATUS", "SPROUT_", "SPROUT_LEF", "LEFT"}) {
    EXPECT_EQ(PartOf(channel), std::nullopt) << channel;
  }
}

TEST(SetPart, ReplacesWhatWasThere) {
  Frame frame;
  SetPart(frame, Part::kSeeds, SeedSet{.seeds = {{1, 2, 3}}, .raw = 5});
  SetPart(frame, Part::kSeeds, SeedSet{.seeds = {}, .raw = 7});
  EXPECT_EQ(*frame.seeds, (SeedSet{.seeds = {}, .raw = 7}));
}

TEST(FrameId, NamesNoFrameUntilItIsSet) {
  EXPECT_EQ(FrameId{}.seq, -1);
  EXPECT_NE((FrameId{.utime = 1, .seq = 2, .rig_id = "a"}),
            (FrameId{.utime = 1, .seq = 2, .rig_id = "b"}));
}

TEST(Seed, ListsAreJoinedOneBehindTheOther) {
  std::vector<Seed> both = {{9, 9, 9}};
  Join(std::vector<Seed>{{1, 2, 0}}, std::vector<Seed>{{3, 4, 1}, {5, 6, 2}}, both);
  EXPECT_EQ(both, (std::vector<Seed>{{1, 2, 0}, {3, 4, 1}, {5, 6, 2}}));
}

TEST(Seed, HasTheDisparityOfItsColumns) {
  EXPECT_FLOAT_EQ((Seed{.u = 20.5F, .v = 3, .u_right = 12.25F}).disparity(), 8.25F);
}

}  // namespace
}  // namespace sprout
