#include "services/view/frame_ring.h"

#include <gtest/gtest.h>

#include "common/logfile/log_reader.h"
#include "tests/common/picture/temporary_directory.h"
#include "tests/common/testing/thrown.h"
#include "tests/services/view/view_frames.h"

namespace sprout::view {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

TEST(FrameRing, HasNothingAtFirst) {
  const FrameRing ring(1 << 20);
  EXPECT_EQ(ring.Newest(), nullptr);
  EXPECT_EQ(ring.Get(0), nullptr);
  EXPECT_EQ(ring.keys(), KeyRange{});
}

// It would be kept, but is not counted.
TEST(FrameRing, RefusesACalibrationThatIsNotWhole) {
  RingInput input;
  auto bytes = Encoded(0, Part::kRig, ViewRig());
  bytes.resize(bytes.size() + (1 << 20));
  EXPECT_EQ(WhyNot(input.ring.Add(ChannelOf(Part::kRig), bytes, input.utime, input.now)),
            "message has 1048576 bytes too many");
  EXPECT_EQ(input.ring.bytes(), 0U);
}

TEST(FrameRing, ShowsAFrameWhenItHasWhatOthersHad) {
  RingInput input;
  AddWhole(input, 0);
  EXPECT_FALSE(input.Add(1, Part::kLeft, ViewImage(1)));
  EXPECT_EQ(input.ring.Newest()->id.seq, 0);
  EXPECT_FALSE(input.Add(1, Part::kDisparity, ViewMap()));
  EXPECT_TRUE(input.Add(1, Part::kSeeds, SeedSet{}));
  EXPECT_EQ(input.ring.Newest()->id.seq, 1);
  EXPECT_TRUE(input.ring.Newest()->Has(Part::kRig));  // of another message, by its name
}

TEST(FrameRing, DoesNotWaitForAStageThatIsGone) {
  RingInput input;
  AddWhole(input, 0);
  input.Wait(seconds(4));
  EXPECT_TRUE(input.Add(1, Part::kLeft, ViewImage(1)));
  EXPECT_EQ(input.ring.Newest()->id.seq, 1);
}

TEST(FrameRing, WaitsForASlowStageAtItsPace) {
  RingInput input;
  AddWhole(input, 0);
  input.Wait(seconds(6));
  AddWhole(input, 1);
  input.Wait(seconds(5));
  EXPECT_FALSE(input.Add(2, Part::kLeft, ViewImage(2)));
  EXPECT_EQ(input.ring.Newest()->id.seq, 1);
}

TEST(FrameRing, KeepsTheNewest100Frames) {
  RingInput input;
  for (int64_t seq = 0; seq < 130; ++seq) {
    AddWhole(input, seq);
    input.Wait(milliseconds(100));
  }
  EXPECT_EQ(input.ring.keys(), (KeyRange{30, 129}));
  EXPECT_EQ(input.ring.Get(29), nullptr);
  EXPECT_EQ(input.ring.Get(30)->id.seq, 30);
  EXPECT_EQ(input.ring.Snapshot().size(), 100U);
  EXPECT_FALSE(input.ring.is_short());
}

TEST(FrameRing, StaysWithinItsBytesAndKeepsTheNewestFrame) {
  RingInput input(100'000);  // ten frames
  for (int64_t seq = 0; seq < 50; ++seq) {
    AddWhole(input, seq);
    input.Wait(milliseconds(100));
    EXPECT_LE(input.ring.bytes(), 100'000U);
  }
  EXPECT_TRUE(input.ring.is_short());
  EXPECT_EQ(input.ring.keys().last, 49);
  EXPECT_GT(input.ring.keys().first, 35);
  EXPECT_LT(input.ring.keys().first, 45);
}

TEST(FrameRing, KeepsItsFramesWhenTheClockIsSetBack) {
  RingInput input(100'000);  // ten frames
  for (int64_t seq = 0; seq < 60; ++seq) {
    if (seq == 25) input.utime -= 3'600'000'000;
    AddWhole(input, seq);
    input.Wait(milliseconds(100));
    EXPECT_LE(input.ring.bytes(), 100'000U);
    EXPECT_GE(input.ring.Snapshot().size(), seq > 10 ? 6U : 1U) << seq;
  }
}

TEST(FrameRing, StaysWithinItsBytesWithoutAnyFrame) {
  RingInput input(10'000);
  const std::vector<uint8_t> status(1000);
  for (int i = 0; i < 100; ++i) {
    input.Wait(seconds(1));
    ASSERT_TRUE(input.ring.Add(kStatusChannel, status, input.utime, input.now));
    EXPECT_LE(input.ring.bytes(), 10'000U);
  }
}

TEST(FrameRing, RefusesWhatIsNotOfTheChannelsType) {
  RingInput input;
  const auto image = Encoded(0, Part::kLeft, ViewImage(0));
  EXPECT_EQ(WhyNot(input.ring.Add(ChannelOf(Part::kDisparity), image, 0, input.now)),
            "not of type sprout.disparity_image_t");
  EXPECT_FALSE(input.ring.Add(ChannelOf(Part::kLeft), {}, 0, input.now));
  EXPECT_EQ(input.ring.bytes(), 0U);
}

TEST(FrameRing, SavesTheLastSecondsAsALogWithItsCalibration) {
  RingInput input;
  for (int64_t seq = 0; seq < 20; ++seq) {
    if (seq == 0) input.Add(seq, Part::kRig, ViewRig());
    input.Add(seq, Part::kLeft, ViewImage(1));
    input.Wait(seconds(1));
  }
  const TemporaryDirectory folder;
  const std::filesystem::path path = folder / "ring.lcm";
  EXPECT_EQ(input.ring.WriteLog(path, "A_", 5), 1 + 6);
  LogReader reader(path);
  LogEvent event;
  ASSERT_TRUE(reader.Next(event));
  EXPECT_EQ(event.channel, "A_SPROUT_RIG");
  int64_t events = 1;
  for (; reader.Next(event); ++events) EXPECT_EQ(event.channel, "A_SPROUT_LEFT");
  EXPECT_EQ(DecodeFrameId(event.data)->seq, 19);
  EXPECT_EQ(events, 7);
}

}  // namespace
}  // namespace sprout::view
