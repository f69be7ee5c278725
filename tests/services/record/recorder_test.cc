#include <gmock/gmock.h>

#include "services/record/recording.h"
#include "tests/common/picture/temporary_directory.h"
#include "tests/services/record/make_event.h"

namespace sprout::record {
namespace {

namespace fs = std::filesystem;
using std::chrono::seconds;
using testing::ElementsAre;

// A recorder with a ring of 3 s that goes on for 2 s, or without one.
class RecorderTest : public testing::Test {
 protected:
  static constexpr RingOptions kRing{
      .length = seconds(3), .max_bytes = 1'000'000, .after = seconds(2)};

  void AddFromTo(Recorder& recorder, int first, int last) {
    for (int i = first; i <= last; ++i) recorder.Add(MakeRecorded(i));
  }

  static bool TriggerAt(Recorder& recorder, double time) {
    return recorder.Trigger(MakeRecorded(time).arrived);
  }

  std::vector<double> Seconds(int number) {
    for (const auto& entry : fs::directory_iterator(directory_ / "")) {
      if (RecordingNumber(entry.path()) == number) return ReadLog(entry.path()).seconds;
    }
    return {};
  }

  TemporaryDirectory directory_;
  LogFolder folder_{
      {.folder = directory_ / "", .max_file_bytes = 1'000'000, .quota_bytes = 1'000'000},
      [] { return MakeRecorded(99); }};
};

TEST_F(RecorderTest, WritesEverythingWithoutARing) {
  Recorder recorder(std::nullopt, folder_);
  recorder.AddStatus(MakeRecorded(0));  // begins no log
  EXPECT_FALSE(folder_.is_open());
  AddFromTo(recorder, 1, 3);
  recorder.AddStatus(MakeRecorded(4));
  EXPECT_FALSE(TriggerAt(recorder, 4));
  recorder.Finish();
  EXPECT_THAT(Seconds(1), ElementsAre(1, 2, 3, 4, 99));
}

TEST_F(RecorderTest, WritesNothingUntilATrigger) {
  Recorder recorder(kRing, folder_);
  AddFromTo(recorder, 1, 10);
  recorder.AddStatus(MakeRecorded(10));
  recorder.Finish();
  EXPECT_EQ(folder_.files(), 0);
}

TEST_F(RecorderTest, IsProlongedByTriggersMeanwhile) {
  Recorder recorder(kRing, folder_);
  AddFromTo(recorder, 1, 10);
  EXPECT_TRUE(TriggerAt(recorder, 10.5));
  AddFromTo(recorder, 11, 12);
  EXPECT_FALSE(TriggerAt(recorder, 12.2));
  AddFromTo(recorder, 13, 20);
  EXPECT_THAT(Seconds(1), ElementsAre(8, 9, 10, 11, 12, 13, 14, 99));
  EXPECT_EQ(folder_.files(), 1);
}

TEST_F(RecorderTest, GivesEveryLogAllOfItsPast) {
  Recorder recorder(kRing, folder_);
  AddFromTo(recorder, 1, 10);
  TriggerAt(recorder, 10.5);
  AddFromTo(recorder, 11, 13);
  AddFromTo(recorder, 14, 15);
  EXPECT_TRUE(TriggerAt(recorder, 15.5));
  AddFromTo(recorder, 16, 21);
  EXPECT_THAT(Seconds(1), ElementsAre(8, 9, 10, 11, 12, 99));
  EXPECT_THAT(Seconds(2), ElementsAre(13, 14, 15, 16, 17, 99));
}

TEST_F(RecorderTest, MergesLogsThatWouldOverlap) {
  Recorder recorder(kRing, folder_);
  AddFromTo(recorder, 1, 10);
  EXPECT_TRUE(TriggerAt(recorder, 10.5));
  AddFromTo(recorder, 11, 14);
  EXPECT_FALSE(TriggerAt(recorder, 14.5));  // its ring has 12 to 14, the log 8 to 12
  AddFromTo(recorder, 15, 30);
  EXPECT_FALSE(folder_.is_open());
  EXPECT_THAT(Seconds(1), ElementsAre(8, 9, 10, 11, 12, 13, 14, 15, 16, 99));
  EXPECT_EQ(folder_.files(), 1);
}

TEST_F(RecorderTest, WritesNoMessageTwiceHoweverFastTriggersCome) {
  Recorder recorder({{.length = seconds(3), .max_bytes = 1'000'000, .after = seconds(0)}}, folder_);
  std::vector<double> expected;
  for (int i = 0; i <= 100; ++i) {  // ten messages and twenty triggers a second
    const double time = 1 + 0.1 * i;
    recorder.Add(MakeRecorded(time));
    TriggerAt(recorder, time + 0.01);
    TriggerAt(recorder, time + 0.06);
    expected.push_back(static_cast<double>(MakeRecorded(time).utime) / 1e6);
  }
  recorder.Finish();
  expected.push_back(99);
  EXPECT_EQ(Seconds(1), expected);
  EXPECT_EQ(folder_.files(), 1);
}

TEST_F(RecorderTest, WritesAMessageThatArrivedBeforeOneThatCameEarlier) {
  Recorder recorder(kRing, folder_);
  AddFromTo(recorder, 1, 2);
  TriggerAt(recorder, 2.5);
  recorder.Add(MakeRecorded(4.6));
  recorder.Add(MakeRecorded(4.4));
  recorder.Finish();
  EXPECT_THAT(Seconds(1), ElementsAre(1, 2, 4.6, 4.4, 99));
}

TEST_F(RecorderTest, BeginsANewLogWhenTheRingWasTooSmallToContinue) {
  const size_t two_messages = 2 * MakeRecorded(0).memory();
  Recorder recorder({{.length = seconds(3), .max_bytes = two_messages, .after = seconds(0)}},
                    folder_);
  AddFromTo(recorder, 1, 2);
  EXPECT_TRUE(TriggerAt(recorder, 2));
  AddFromTo(recorder, 3, 4);
  EXPECT_TRUE(TriggerAt(recorder, 4));
  recorder.Finish();
  EXPECT_THAT(Seconds(1), ElementsAre(1, 2, 99));
  EXPECT_THAT(Seconds(2), ElementsAre(3, 4, 99));
}

TEST_F(RecorderTest, BeginsANewLogAfterSilence) {
  Recorder recorder(kRing, folder_);
  AddFromTo(recorder, 1, 2);
  TriggerAt(recorder, 2.5);
  EXPECT_TRUE(TriggerAt(recorder, 50));
  AddFromTo(recorder, 51, 51);
  recorder.Finish();
  EXPECT_THAT(Seconds(1), ElementsAre(1, 2, 99));
  EXPECT_THAT(Seconds(2), ElementsAre(51, 99));
}

// A reached quota counts as a full disk.
TEST_F(RecorderTest, CountsWhatATriggerAskedForAndDidNotFit) {
  const int64_t bytes = RecordingFile::BytesOf(MakeRecorded(0));
  LogFolder small({.folder = directory_ / "small",
                   .max_file_bytes = 1'000'000,
                   .quota_bytes = 2 * bytes + bytes / 2},
                  [] { return MakeRecorded(99); });
  Recorder recorder({{.length = seconds(30), .max_bytes = 1'000'000, .after = seconds(2)}}, small);
  AddFromTo(recorder, 1, 10);
  EXPECT_EQ(recorder.unwritten(), 0) << "nobody asked for them yet";
  EXPECT_THROW(TriggerAt(recorder, 10.5), LogError);
  EXPECT_EQ(small.events(), 2);
  EXPECT_EQ(recorder.unwritten(), 8);
}

TEST_F(RecorderTest, CountsTheMessageThatDidNotFitBehindATrigger) {
  const int64_t bytes = RecordingFile::BytesOf(MakeRecorded(0));
  for (const bool has_ring : {true, false}) {
    LogFolder small({.folder = directory_ / (has_ring ? "ring" : "all"),
                     .max_file_bytes = 1'000'000,
                     .quota_bytes = 2 * bytes + bytes / 2},
                    [] { return MakeRecorded(99); });
    Recorder recorder(has_ring ? std::optional(kRing) : std::nullopt, small);
    AddFromTo(recorder, 1, 1);
    TriggerAt(recorder, 1.5);
    AddFromTo(recorder, 2, 2);
    EXPECT_EQ(recorder.unwritten(), 0);
    EXPECT_THROW(recorder.Add(MakeRecorded(3)), LogError);
    EXPECT_EQ(recorder.unwritten(), 1);
  }
}

}  // namespace
}  // namespace sprout::record
