#include "common/frames/frame_joiner.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/common/frames/joiner_messages.h"

// What belongs together.
namespace sprout {
namespace {

const PartSet kPair = {Part::kLeft, Part::kRight};
const PartSet kPairAndRig = {Part::kLeft, Part::kRight, Part::kRig};

TEST(FrameJoiner, CompletesAFrameOnceAllItsPartsAreThereInAnyOrder) {
  std::vector<Part> order(std::begin(kAllParts), std::end(kAllParts));
  for (int round = 0; round < 200; ++round) {
    FrameJoiner joiner(AllParts());
    for (size_t i = 0; i + 1 < order.size(); ++i) {
      ASSERT_EQ(AddTo(joiner, IdOf(3), order[i], 10 + static_cast<int>(order[i])), Seqs{});
    }
    const std::vector<Frame> frames = joiner.Add(
        IdOf(3), order.back(), ValueOf(order.back(), 10 + static_cast<int>(order.back())));
    ASSERT_EQ(frames.size(), 1U);
    const Frame& frame = frames[0];
    EXPECT_EQ(frame.id, IdOf(3));
    EXPECT_EQ(frame.left.at<uint8_t>(0, 0), 10);
    EXPECT_EQ(frame.right.at<uint8_t>(0, 0), 11);
    EXPECT_EQ(frame.tof->depth_m(0, 0), 12.0F);
    EXPECT_EQ(frame.rig->pair.width, 13);
    EXPECT_EQ(frame.seeds->raw, 14);
    EXPECT_EQ(frame.left_seeds->raw, 15);
    EXPECT_EQ(frame.prior->disparity.counts()(0, 0), 16);
    EXPECT_EQ(frame.unfilled->counts()(0, 0), 17);
    EXPECT_EQ(frame.disparity->counts()(0, 0), 18);
    EXPECT_EQ(frame.confidence.at<uint8_t>(0, 0), 19);
    std::next_permutation(order.begin(), order.end());
    if (round % 7 == 0) std::rotate(order.begin(), order.begin() + 3, order.end());
  }
}

TEST(FrameJoiner, LeavesEmptyWhatWasNotAskedFor) {
  FrameJoiner joiner(PartSet{Part::kLeft});
  const std::vector<Frame> frames = joiner.Add(IdOf(0), Part::kLeft, ValueOf(Part::kLeft, 1));
  ASSERT_EQ(frames.size(), 1U);
  EXPECT_TRUE(frames[0].right.empty());
  EXPECT_FALSE(frames[0].tof || frames[0].rig || frames[0].seeds || frames[0].prior ||
               frames[0].unfilled || frames[0].disparity);
  EXPECT_TRUE(frames[0].confidence.empty());
}

TEST(FrameJoiner, ReplacesAPartThatComesTwice) {
  FrameJoiner joiner(kPair);
  AddTo(joiner, IdOf(0), Part::kLeft, 1);
  AddTo(joiner, IdOf(0), Part::kLeft, 2);
  const std::vector<Frame> frames = joiner.Add(IdOf(0), Part::kRight, ValueOf(Part::kRight, 3));
  ASSERT_EQ(frames.size(), 1U);
  EXPECT_EQ(frames[0].left.at<uint8_t>(0, 0), 2);
  EXPECT_EQ(joiner.incomplete(), 0);
}

TEST(FrameJoiner, UsesAnEarlyCalibrationForEveryFrameThatNamesIt) {
  FrameJoiner joiner(kPairAndRig);
  EXPECT_EQ(AddTo(joiner, IdOf(0), Part::kRig, 7), Seqs{});
  for (int64_t seq = 0; seq < 3; ++seq) {
    EXPECT_EQ(AddTo(joiner, IdOf(seq), Part::kLeft), Seqs{});
    const auto frames = joiner.Add(IdOf(seq), Part::kRight, ValueOf(Part::kRight, 1));
    ASSERT_EQ(frames.size(), 1U);
    EXPECT_EQ(frames[0].rig->pair.width, 7);
  }
}

TEST(FrameJoiner, CompletesEveryWaitingFrameWhenItsCalibrationComesLate) {
  FrameJoiner joiner(kPairAndRig);
  for (int64_t seq = 0; seq < 3; ++seq) {
    EXPECT_EQ(AddTo(joiner, IdOf(seq), Part::kLeft), Seqs{});
    EXPECT_EQ(AddTo(joiner, IdOf(seq), Part::kRight), Seqs{});
  }
  AddTo(joiner, IdOf(3), Part::kLeft);
  EXPECT_EQ(AddTo(joiner, IdOf(9), Part::kRig), (Seqs{0, 1, 2})) << "oldest first";
  EXPECT_EQ(joiner.incomplete(), 0);
  EXPECT_EQ(AddTo(joiner, IdOf(3), Part::kRight), Seqs{3}) << "frame 3 went on waiting";
}

TEST(FrameJoiner, DropsTheUnfinishedBetweenFramesThatALateCalibrationCompletes) {
  FrameJoiner joiner(kPairAndRig);
  for (const int64_t seq : {0, 1, 2}) AddTo(joiner, IdOf(seq), Part::kLeft);
  AddTo(joiner, IdOf(0), Part::kRight);
  AddTo(joiner, IdOf(2), Part::kRight);
  EXPECT_EQ(AddTo(joiner, IdOf(0), Part::kRig), (Seqs{0, 2}));
  EXPECT_EQ(joiner.incomplete(), 1);
}

TEST(FrameJoiner, DoesNotUseTheCalibrationOfAnotherRig) {
  FrameJoiner joiner(kPairAndRig);
  AddTo(joiner, IdOf(0, "old"), Part::kRig, 1);
  AddTo(joiner, IdOf(5, "new"), Part::kLeft);
  EXPECT_EQ(AddTo(joiner, IdOf(5, "new"), Part::kRight), Seqs{});
  const auto frames = joiner.Add(IdOf(5, "new"), Part::kRig, ValueOf(Part::kRig, 2));
  ASSERT_EQ(frames.size(), 1U);
  EXPECT_EQ(frames[0].rig->pair.width, 2);
}

TEST(FrameJoiner, TakesTheNewestCalibrationOfAName) {
  FrameJoiner joiner(kPairAndRig);
  AddTo(joiner, IdOf(0), Part::kRig, 1);
  AddTo(joiner, IdOf(1), Part::kRig, 2);
  AddTo(joiner, IdOf(1), Part::kLeft);
  EXPECT_EQ(joiner.Add(IdOf(1), Part::kRight, ValueOf(Part::kRight, 1))[0].rig->pair.width, 2);
  AddTo(joiner, IdOf(2), Part::kRig, 2);
  EXPECT_EQ(joiner.rigs_replaced(), 1);
}

TEST(FrameJoiner, ForgetsOldCalibrationsButNotTheOneThatIsSentEverySecond) {
  FrameJoiner joiner(PartSet{Part::kLeft, Part::kRig});
  AddTo(joiner, IdOf(0, "ours"), Part::kRig);
  AddTo(joiner, IdOf(0, "stray"), Part::kRig);
  for (const char* other : {"a", "b", "c"}) {
    AddTo(joiner, IdOf(0, other), Part::kRig);
    AddTo(joiner, IdOf(0, "ours"), Part::kRig);
  }
  EXPECT_EQ(AddTo(joiner, IdOf(1, "ours"), Part::kLeft), Seqs{1});
  EXPECT_EQ(AddTo(joiner, IdOf(2, "stray"), Part::kLeft), Seqs{});
}

TEST(FrameJoiner, DoesNotMixPartsOfTheSameNumberFromOtherCaptures) {
  FrameJoiner joiner(kPair);
  FrameId other_time = IdOf(4);
  other_time.utime += 1;
  EXPECT_EQ(AddTo(joiner, IdOf(4), Part::kLeft), Seqs{});
  EXPECT_EQ(AddTo(joiner, other_time, Part::kRight), Seqs{});
  EXPECT_EQ(AddTo(joiner, IdOf(4, "other rig"), Part::kRight), Seqs{});
  EXPECT_EQ(AddTo(joiner, other_time, Part::kLeft), Seqs{4});
}

}  // namespace
}  // namespace sprout
