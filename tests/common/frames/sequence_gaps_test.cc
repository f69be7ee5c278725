#include "common/frames/sequence_gaps.h"

#include <gtest/gtest.h>

#include <initializer_list>

namespace sprout {
namespace {

constexpr int64_t kPeriod = 100'000;  // µs

// Frame `seq` of a stream whose frame 0 was captured at `start`.
FrameId IdOf(int64_t seq, int64_t start = 1'000'000'000) {
  return {.utime = start + kPeriod * seq, .seq = seq, .rig_id = "rig"};
}

void AddAll(SequenceGaps& gaps, std::initializer_list<int64_t> seqs,
            int64_t start = 1'000'000'000) {
  for (const int64_t seq : seqs) gaps.Add(IdOf(seq, start));
}

// Every other one of 100 frames.
void AddHalf(SequenceGaps& gaps, int64_t start) {
  for (int64_t seq = 0; seq < 100; seq += 2) gaps.Add(IdOf(seq, start));
}

TEST(SequenceGaps, CountsWhatIsLeftOutOfAStreamThatMayStartAnywhere) {
  SequenceGaps gaps;
  AddAll(gaps, {7, 8, 11, 13});
  EXPECT_EQ(gaps.count(), 3);
}

TEST(SequenceGaps, CountsFromTheStartWhenCaptureIsStartedAgain) {
  SequenceGaps gaps;
  AddAll(gaps, {100, 101});
  AddAll(gaps, {0, 1, 4}, 2'000'000'000);
  EXPECT_EQ(gaps.count(), 2);
}

TEST(SequenceGaps, GoesOnCountingWhenCaptureIsStartedAgainWithItsClockSetBack) {
  SequenceGaps gaps;
  for (int64_t seq = 0; seq < 200; ++seq) gaps.Add(IdOf(seq));
  AddHalf(gaps, 1'000'000'000 - 10'000'000);
  EXPECT_EQ(gaps.count(), 49);
}

TEST(SequenceGaps, GoesOnCountingWhenARecordingPlaysAgain) {
  SequenceGaps gaps;
  for (int64_t seq = 0; seq < 100; ++seq) gaps.Add(IdOf(seq));
  for (int pass = 1; pass <= 3; ++pass) {
    AddHalf(gaps, 1'000'000'000);
    EXPECT_EQ(gaps.count(), 49 * pass);
  }
}

TEST(SequenceGaps, GoesOnCountingAfterOneMessageWithTheLargestNumbers) {
  SequenceGaps gaps;
  AddAll(gaps, {0, 1});
  gaps.Add({.utime = INT64_MAX, .seq = INT64_MAX, .rig_id = ""});
  EXPECT_EQ(gaps.count(), 0) << "a stray message is no gap";
  AddAll(gaps, {2, 3, 5});
  EXPECT_EQ(gaps.count(), 1);
  // A stream that begins with such a message.
  SequenceGaps other;
  other.Add({.utime = INT64_MAX, .seq = INT64_MAX, .rig_id = ""});
  AddHalf(other, 1'000'000'000);
  EXPECT_EQ(other.count(), 49);
}

TEST(SequenceGaps, GoesOnCountingAfterOneMessageFromTheFuture) {
  SequenceGaps gaps;
  AddAll(gaps, {0, 1});
  gaps.Add({.utime = INT64_MAX, .seq = 1000, .rig_id = ""});
  const int64_t claimed = gaps.count();
  AddHalf(gaps, 1'000'000'000);
  EXPECT_EQ(gaps.count(), claimed + 48) << "frame 2 continues what was before the message";
}

TEST(SequenceGaps, CountsTheGapsOfEachOfTwoCaptures) {
  SequenceGaps gaps;
  // One has larger numbers, and a clock that is behind; the other one sends every third time.
  for (int64_t i = 0; i < 300; ++i) {
    if (i != 200) gaps.Add(IdOf(1000 + i, -50'000'000));
    if (i % 3 == 0 && i != 150) gaps.Add(IdOf(i / 3));
  }
  EXPECT_EQ(gaps.count(), 2) << "frames 1200 and 50";
}

TEST(SequenceGaps, CountsGapsThatReachBeyondWhereAnEarlierCaptureEnded) {
  SequenceGaps gaps;
  AddAll(gaps, {28, 29, 30});
  AddAll(gaps, {0, 1, 40}, 2'000'000'000);
  EXPECT_EQ(gaps.count(), 38);
}

TEST(SequenceGaps, TakesFramesThatAreSentAgainForNeitherAGapNorAStart) {
  SequenceGaps gaps;
  AddAll(gaps, {0, 1, 2, 3});
  EXPECT_FALSE(gaps.Add(IdOf(0)));
  AddAll(gaps, {3, 3, 0, 2, 4});
  EXPECT_EQ(gaps.count(), 0);
  AddAll(gaps, {1, 3, 6});
  EXPECT_EQ(gaps.count(), 1) << "frame 5";
}

TEST(SequenceGaps, SaysWhenTheStreamStartsOver) {
  SequenceGaps gaps;
  for (int64_t seq = 0; seq < 20; ++seq) EXPECT_FALSE(gaps.Add(IdOf(seq)));
  EXPECT_TRUE(gaps.Add(IdOf(0, 2'000'000'000))) << "started again: known at once";
  for (int64_t seq = 1; seq < 20; ++seq) gaps.Add(IdOf(seq, 2'000'000'000));
  for (int64_t seq = 0; seq < SequenceGaps::kRestartFrames - 1; ++seq) {
    EXPECT_FALSE(gaps.Add(IdOf(seq)));
  }
  EXPECT_TRUE(gaps.Add(IdOf(SequenceGaps::kRestartFrames - 1)));
}

TEST(SequenceGaps, CountsFramesWhoseTimeDoesNotRiseWithTheirNumber) {
  SequenceGaps gaps;
  AddAll(gaps, {0, 1, 2, 2, 1});        // sent again
  AddAll(gaps, {0, 1}, 2'000'000'000);  // started again
  EXPECT_EQ(gaps.times_back(), 0);
  gaps.Add({.utime = IdOf(1, 2'000'000'000).utime, .seq = 2, .rig_id = ""});
  EXPECT_EQ(gaps.times_back(), 1) << "it stood still";
  AddAll(gaps, {3, 4});
  EXPECT_EQ(gaps.times_back(), 2) << "it went back once";
}

TEST(SequenceGaps, SurvivesNumbersAtBothEnds) {
  SequenceGaps gaps;
  for (const int64_t seq : {int64_t{-1}, INT64_MAX, int64_t{0}, INT64_MAX - 1, INT64_MAX}) {
    for (const int64_t utime : {int64_t{0}, INT64_MAX}) {
      gaps.Add({.utime = utime, .seq = seq, .rig_id = ""});
    }
  }
  EXPECT_LE(gaps.count(), 1'000'000);
}

}  // namespace
}  // namespace sprout
