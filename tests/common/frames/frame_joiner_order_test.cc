#include <gtest/gtest.h>

#include "common/frames/frame_joiner.h"
#include "tests/common/frames/joiner_messages.h"

// What is dropped, left out, or sent again; and that each is counted once.
namespace sprout {
namespace {

const PartSet kStereo = {Part::kLeft, Part::kRight};

void AddPair(FrameJoiner& joiner, int64_t seq) {
  AddTo(joiner, IdOf(seq), Part::kLeft);
  EXPECT_EQ(AddTo(joiner, IdOf(seq), Part::kRight), Seqs{seq});
}

TEST(FrameJoiner, DropsUnfinishedFramesOlderThanACompleteOne) {
  FrameJoiner joiner(kStereo);
  for (const int64_t seq : {0, 1, 2}) AddTo(joiner, IdOf(seq), Part::kLeft);
  EXPECT_EQ(AddTo(joiner, IdOf(1), Part::kRight), Seqs{1});
  EXPECT_EQ(joiner.incomplete(), 1) << "frame 0";
  EXPECT_EQ(AddTo(joiner, IdOf(2), Part::kRight), Seqs{2}) << "the newer one went on";
  EXPECT_EQ(joiner.incomplete(), 1);
  EXPECT_EQ(AddTo(joiner, IdOf(0), Part::kRight), Seqs{}) << "what was dropped stays dropped";
}

TEST(FrameJoiner, WaitsForOptionalPartsUntilTheNextFrameHasAllOthers) {
  FrameJoiner joiner({Part::kLeft, Part::kRight, Part::kOdometry}, FrameJoiner::kDefaultMaxPending,
                     FrameJoiner::kDefaultMaxBytes, {Part::kOdometry});
  const auto add_pair = [&](int seq) {
    Seqs seqs = AddTo(joiner, IdOf(seq), Part::kLeft, 1);
    const Seqs more = AddTo(joiner, IdOf(seq), Part::kRight, 1);
    seqs.insert(seqs.end(), more.begin(), more.end());
    return seqs;
  };
  EXPECT_EQ(add_pair(0), Seqs{});
  EXPECT_EQ(AddTo(joiner, IdOf(0), Part::kOdometry, 1), Seqs{0});  // in time
  EXPECT_EQ(add_pair(1), Seqs{});
  EXPECT_EQ(add_pair(2), Seqs{1});
  EXPECT_EQ(AddTo(joiner, IdOf(1), Part::kOdometry, 1), Seqs{});  // too late
  EXPECT_EQ(AddTo(joiner, IdOf(3), Part::kLeft, 1), Seqs{});
  EXPECT_EQ(add_pair(4), Seqs{2});
  EXPECT_EQ(AddTo(joiner, IdOf(4), Part::kOdometry, 1), Seqs{4});
  EXPECT_EQ(joiner.incomplete(), 1);  // 3 has no right image
  EXPECT_EQ(add_pair(5), Seqs{});
  EXPECT_EQ(AddTo(joiner, IdOf(6), Part::kLeft, 1), Seqs{});
  const std::vector<Frame> last = joiner.DropPending();
  ASSERT_EQ(last.size(), 1U);
  EXPECT_EQ(last[0].id.seq, 5);
  EXPECT_FALSE(last[0].odometry);
  EXPECT_EQ(joiner.incomplete(), 2);
}

TEST(FrameJoiner, DropsTheOldestWhenTooManyWait) {
  FrameJoiner joiner(kStereo, 3);
  for (int64_t seq = 0; seq < 5; ++seq) AddTo(joiner, IdOf(seq), Part::kLeft);
  EXPECT_EQ(joiner.incomplete(), 2);
  EXPECT_EQ(AddTo(joiner, IdOf(2), Part::kRight), Seqs{2}) << "three are kept";
  EXPECT_EQ(joiner.incomplete(), 2);
}

// A stage that was stopped answers, when it goes on, a frame that was given up long ago.
TEST(FrameJoiner, CountsLeftoversOnceWhenCaptureIsStartedAgain) {
  FrameJoiner joiner(kStereo, 3);
  for (int64_t seq = 0; seq < 4; ++seq) AddTo(joiner, IdOf(seq), Part::kLeft);
  EXPECT_EQ(joiner.incomplete(), 1) << "frame 0";
  AddTo(joiner, IdOf(0), Part::kRight);
  EXPECT_EQ(AddTo(joiner, IdOf(3), Part::kRight), Seqs{3});
  EXPECT_EQ(joiner.incomplete(), 3) << "frames 1 and 2";
  for (const Part part : {Part::kLeft, Part::kRight}) {
    AddTo(joiner, {.utime = 9'000'000, .seq = 0, .rig_id = "rig"}, part);
  }
  joiner.DropPending();
  EXPECT_EQ(joiner.incomplete(), 3);
}

PartValue ImageOf(size_t bytes) { return cv::Mat(1, static_cast<int>(bytes), CV_8UC1); }

TEST(FrameJoiner, DropsTheOldestWhenTheUnfinishedTakeTooMuchMemory) {
  FrameJoiner joiner(kStereo, 16, /*max_bytes=*/1000);
  for (int64_t seq = 0; seq < 3; ++seq) joiner.Add(IdOf(seq), Part::kLeft, ImageOf(300));
  EXPECT_EQ(joiner.incomplete(), 0);
  joiner.Add(IdOf(2), Part::kLeft, ImageOf(400));  // instead of the one that it has
  EXPECT_EQ(joiner.incomplete(), 0) << "exactly as much as allowed";
  joiner.Add(IdOf(3), Part::kLeft, ImageOf(500));
  EXPECT_EQ(joiner.incomplete(), 2) << "frames 0 and 1";
  EXPECT_FALSE(joiner.IsPending(IdOf(1)));
  EXPECT_TRUE(joiner.IsPending(IdOf(2)));
  EXPECT_EQ(joiner.Add(IdOf(2), Part::kRight, ImageOf(400)).size(), 1U) << "whole frames leave";
  joiner.Add(IdOf(4), Part::kLeft, ImageOf(1001));
  EXPECT_EQ(joiner.incomplete(), 4) << "one frame alone may not take more either";
}

TEST(FrameJoiner, KnowsTheSizeOfAFramesImagesFromTheCalibrationOrElseFromItsFirstImage) {
  FrameJoiner joiner({Part::kLeft, Part::kPrior});
  EXPECT_EQ(joiner.ImageSizeOf(IdOf(0)), std::nullopt);
  joiner.Add(IdOf(0), Part::kLeft, cv::Mat(2, 3, CV_8UC1));
  EXPECT_EQ(joiner.ImageSizeOf(IdOf(0)), cv::Size(3, 2));
  EXPECT_EQ(joiner.ImageSizeOf(IdOf(1)), std::nullopt) << "another frame may have another size";
  joiner.Add(IdOf(1), Part::kPrior, PriorMap(cv::Size(5, 4)));
  EXPECT_EQ(joiner.ImageSizeOf(IdOf(1)), cv::Size(5, 4));
  Rig rig;
  rig.pair.width = 7;
  rig.pair.height = 6;
  joiner.Add(IdOf(9), Part::kRig, rig);
  EXPECT_EQ(joiner.ImageSizeOf(IdOf(0)), cv::Size(7, 6));
  EXPECT_EQ(joiner.ImageSizeOf(IdOf(0, "other rig")), std::nullopt);
}

TEST(FrameJoiner, CountsAFrameThatWasDroppedOnce) {
  FrameJoiner joiner(kStereo, 1);
  AddTo(joiner, IdOf(0), Part::kLeft);
  AddTo(joiner, IdOf(1), Part::kLeft);   // drops frame 0 ...
  AddTo(joiner, IdOf(0), Part::kRight);  // ... whose other part comes late, and drops frame 1
  AddTo(joiner, IdOf(2), Part::kLeft);   // drops the leftover of frame 0
  EXPECT_EQ(joiner.incomplete(), 2);
}

TEST(FrameJoiner, CountsTheFrameNumbersThatAreLeftOut) {
  FrameJoiner joiner(kStereo);
  AddPair(joiner, 7);
  EXPECT_EQ(joiner.sequence_gaps(), 0) << "a stream may start anywhere";
  AddPair(joiner, 8);
  EXPECT_EQ(joiner.sequence_gaps(), 0);
  AddPair(joiner, 11);
  EXPECT_EQ(joiner.sequence_gaps(), 2);
  AddTo(joiner, IdOf(13), Part::kLeft);
  EXPECT_EQ(joiner.sequence_gaps(), 3) << "an unfinished frame was not left out";
  EXPECT_EQ(joiner.incomplete(), 0);
}

TEST(FrameJoiner, DoesNotMissTheLeftoversOfAFrameThatWasSentTwice) {
  FrameJoiner joiner(kStereo);
  AddPair(joiner, 0);
  AddTo(joiner, IdOf(0), Part::kLeft);  // the second copy of RIGHT is lost
  AddPair(joiner, 1);
  EXPECT_EQ(joiner.incomplete(), 0);
  AddTo(joiner, IdOf(2), Part::kLeft);  // a frame that never was complete is missed
  AddPair(joiner, 3);
  EXPECT_EQ(joiner.incomplete(), 1);
}

TEST(FrameJoiner, JoinsAnOlderFrameThatIsSentAgain) {
  FrameJoiner joiner(kStereo);
  AddTo(joiner, IdOf(0), Part::kLeft);
  AddPair(joiner, 1);
  EXPECT_EQ(joiner.incomplete(), 1);
  AddPair(joiner, 0);
  EXPECT_EQ(joiner.incomplete(), 1);
  EXPECT_EQ(joiner.sequence_gaps(), 0) << "an older frame is no restart";
  AddPair(joiner, 2);
  EXPECT_EQ(joiner.sequence_gaps(), 0);
}

TEST(FrameJoiner, CountsAnUnfinishedFrameWhenARecordingPlaysAgain) {
  FrameJoiner joiner(kStereo);
  for (int pass = 0; pass < 2; ++pass) {
    for (int64_t seq = 0; seq < 20; ++seq) {
      AddTo(joiner, IdOf(seq), Part::kLeft);
      if (pass == 1 && seq == 15) continue;  // as complete as any other the first time
      EXPECT_EQ(AddTo(joiner, IdOf(seq), Part::kRight), Seqs{seq});
    }
  }
  EXPECT_EQ(joiner.incomplete(), 1);
  EXPECT_EQ(joiner.sequence_gaps(), 0);
}

TEST(FrameJoiner, KeepsCountingOverManyFrames) {
  FrameJoiner joiner(kStereo);
  for (int64_t seq = 0; seq < 1000; ++seq) {
    AddTo(joiner, IdOf(seq), Part::kLeft);
    if (seq % 10 != 5) {
      EXPECT_EQ(AddTo(joiner, IdOf(seq), Part::kRight), Seqs{seq});
    }
  }
  EXPECT_EQ(joiner.incomplete(), 100);
  EXPECT_EQ(joiner.sequence_gaps(), 0);
}

}  // namespace
}  // namespace sprout
