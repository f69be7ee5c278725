#include <gmock/gmock.h>

#include <filesystem>

#include "services/capture/source_feed.h"
#include "tests/common/app/captured_log.h"
#include "tests/common/app/log_files.h"
#include "tests/common/picture/temporary_directory.h"
#include "tests/common/testing/thrown.h"

namespace sprout::capture {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

using Messages = std::vector<std::pair<Part, std::vector<uint8_t>>>;

class LogFeedTest : public ::testing::Test {
 protected:
  LogFeedTest() : path_(folder_ / "in.lcm") {}

  std::unique_ptr<CaptureFeed> Open(const std::vector<TestEvent>& events, bool loop = false,
                                    const std::string& prefix = "") {
    WriteLog(path_, events);
    return OpenLogFeed(path_, prefix, loop, monitor_);
  }

  std::string ErrorOf(const std::vector<TestEvent>& events, const std::string& prefix = "") {
    return Thrown<ConfigError>([&] { Open(events, false, prefix); });
  }

  // Numbers of all frames that are left.
  static std::vector<int64_t> Seqs(CaptureFeed& feed) {
    std::vector<int64_t> seqs;
    while (const auto frame = feed.Next({})) seqs.push_back(frame->id.seq);
    return seqs;
  }

  CapturedLog log_;
  TemporaryDirectory folder_;
  std::string path_;
  StageMonitor monitor_{"capture", ""};
};

std::vector<TestEvent> FrameEvents(int64_t seq, const std::string& prefix = "") {
  return {LeftEvent(seq, 50, prefix), RightEvent(seq, prefix), TofEvent(seq, prefix)};
}

std::vector<TestEvent> Concat(std::vector<std::vector<TestEvent>> parts) {
  std::vector<TestEvent> all;
  for (const auto& part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}

TEST_F(LogFeedTest, GivesTheZonesOfALogThatHasThem) {
  const auto zones = [](int64_t seq) {
    TestEvent event = TofEvent(seq);
    event.channel = "SPROUT_TOF_ZONES";
    event.data = EncodePart(TestId(seq), Part::kTofZones, TofZones());
    return event;
  };
  // It begins between the zones and the ToF image of a frame.
  const auto feed = Open({RigEvent(0), TofEvent(0), LeftEvent(1, 50), RightEvent(1), zones(1),
                          TofEvent(1), LeftEvent(2, 50), RightEvent(2), TofEvent(2)});
  const auto first = feed->Next({}).value();
  EXPECT_EQ(first.id, TestId(1));
  EXPECT_EQ(first.messages, (Messages{{Part::kRig, RigEvent(0).data},
                                      {Part::kLeft, LeftEvent(1, 50).data},
                                      {Part::kRight, RightEvent(1).data},
                                      {Part::kTofZones, zones(1).data},
                                      {Part::kTof, TofEvent(1).data}}));
  EXPECT_FALSE(feed->Next({})) << "without its zones a frame is not whole";
}

TEST_F(LogFeedTest, GivesEveryFrameByteByByteAsItWasRecorded) {
  // A stride that our own encoder would not write.
  image_t padded = ToMessage(TestId(1), cv::Mat(2, 3, CV_8UC1, cv::Scalar(7)));
  padded.row_stride = 5;
  padded.data.resize(10, 99);
  padded.size = 10;
  TestEvent left = LeftEvent(1, 0);
  left.data.resize(static_cast<size_t>(padded.getEncodedSize()));
  padded.encode(left.data.data(), 0, static_cast<int>(left.data.size()));

  const auto feed =
      Open(Concat({{RigEvent(0)}, FrameEvents(0), {TofEvent(1), RightEvent(1), left}}));
  EXPECT_EQ(feed->timing(), Timing::kRecorded);
  EXPECT_EQ(feed->Calibration(), RigEvent(0).data);
  const auto first = feed->Next({}).value();
  EXPECT_EQ(first.id, TestId(0));
  EXPECT_EQ(first.messages, (Messages{{Part::kRig, RigEvent(0).data},
                                      {Part::kLeft, LeftEvent(0, 50).data},
                                      {Part::kRight, RightEvent(0).data},
                                      {Part::kTof, TofEvent(0).data}}));
  const auto second = feed->Next({}).value();
  EXPECT_EQ(second.id, TestId(1));
  EXPECT_EQ(second.messages, (Messages{{Part::kTof, TofEvent(1).data},
                                       {Part::kRight, RightEvent(1).data},
                                       {Part::kLeft, left.data}}));
  EXPECT_FALSE(feed->Next({}));
  EXPECT_FALSE(feed->Next({}));
}

TEST_F(LogFeedTest, KnowsTheCalibrationThatComesLateInTheLog) {
  const auto feed = Open(Concat({FrameEvents(0), FrameEvents(1), {RigEvent(1)}, FrameEvents(2)}));
  EXPECT_EQ(feed->Calibration(), RigEvent(1).data);
  EXPECT_THAT(Seqs(*feed), ElementsAre(0, 1, 2));
}

TEST_F(LogFeedTest, SendsAChangedCalibrationBeforeTheFrameThatNeedsIt) {
  const auto feed = Open(Concat({{RigEvent(0)}, FrameEvents(0), {RigEvent(1)}, FrameEvents(1)}));
  feed->Next({});
  EXPECT_EQ(feed->Calibration(), RigEvent(0).data);
  const auto second = feed->Next({});
  EXPECT_EQ(second->messages.front(), (std::pair{Part::kRig, RigEvent(1).data}));
  EXPECT_EQ(feed->Calibration(), RigEvent(1).data);
}

TEST_F(LogFeedTest, CountsAndLeavesOutAFrameThatNoStageCouldAnswer) {
  TestEvent bad = LeftEvent(2, 50);
  bad.data.pop_back();
  const auto feed = Open(Concat({{RigEvent(0)},
                                 FrameEvents(0),
                                 {LeftEvent(1, 50), TofEvent(1)},
                                 {bad, RightEvent(2), TofEvent(2)},
                                 FrameEvents(3),
                                 {LeftEvent(4, 50)}}));
  EXPECT_THAT(Seqs(*feed), ElementsAre(0, 3));
  EXPECT_EQ(monitor_.Snapshot().frames_incomplete, 3);
  EXPECT_EQ(monitor_.Snapshot().bad_messages, 1);
  EXPECT_TRUE(feed->lacks_something());
}

TEST_F(LogFeedTest, CountsAndLeavesOutFramesWithoutTheirCalibration) {
  const auto of_another_rig = [](int64_t seq) {
    FrameId id = TestId(seq);
    id.rig_id = "another";
    return std::vector<TestEvent>{
        {seq, "SPROUT_LEFT", EncodePart(id, Part::kLeft, cv::Mat1b(2, 3))},
        {seq, "SPROUT_RIGHT", EncodePart(id, Part::kRight, cv::Mat1b(2, 3))},
        {seq, "SPROUT_TOF", EncodePart(id, Part::kTof, examples::Tof(false))}};
  };
  const auto feed =
      Open(Concat({{RigEvent(0)}, FrameEvents(0), of_another_rig(1), FrameEvents(2)}));
  EXPECT_THAT(Seqs(*feed), ElementsAre(0, 2));
  EXPECT_EQ(monitor_.Snapshot().frames_incomplete, 1);
  EXPECT_THAT(ErrorOf(Concat({{RigEvent(0)}, of_another_rig(1)})),
              HasSubstr("SPROUT_TOF in it with the rig_id of a SPROUT_RIG; it has"));
}

TEST_F(LogFeedTest, KeepsNoMoreThanAFewUnfinishedFrames) {
  std::vector<TestEvent> events = {RigEvent(0)};
  for (int64_t seq = 0; seq < 40; ++seq) events.push_back(LeftEvent(seq, 50));
  for (const int64_t seq : {0, 39}) {
    events.push_back(RightEvent(seq));
    events.push_back(TofEvent(seq));
  }
  const auto feed = Open(events);
  EXPECT_THAT(Seqs(*feed), ElementsAre(39));
  EXPECT_EQ(monitor_.Snapshot().frames_incomplete, 39);
}

TEST_F(LogFeedTest, GivesAFrameTwiceThatWasSentTwice) {
  const auto feed = Open(Concat({{RigEvent(0)}, FrameEvents(0), FrameEvents(0), FrameEvents(1)}));
  EXPECT_THAT(Seqs(*feed), ElementsAre(0, 0, 1));
}

TEST_F(LogFeedTest, StartsAgainAtTheEndOnDemand) {
  const auto feed = Open(Concat({{RigEvent(0)}, FrameEvents(0), FrameEvents(1)}), /*loop=*/true);
  for (const int64_t seq : {0, 1, 0, 1, 0}) EXPECT_EQ(feed->Next({})->id, TestId(seq));
}

TEST_F(LogFeedTest, CountsWhatWasLostInEveryRound) {
  const auto feed =
      Open(Concat({{RigEvent(0)}, FrameEvents(0), {LeftEvent(1, 50)}, FrameEvents(2)}),
           /*loop=*/true);
  for (const int64_t seq : {0, 2, 0, 2, 0, 2}) EXPECT_EQ(feed->Next({})->id, TestId(seq));
  EXPECT_EQ(feed->Next({})->id, TestId(0));
  EXPECT_EQ(monitor_.Snapshot().frames_incomplete, 3);
}

TEST_F(LogFeedTest, ReadsChannelsWithAPrefixWhenToldTo) {
  const auto events =
      Concat({{RigEvent(0, "A_"), RigEvent(9)}, FrameEvents(0), FrameEvents(1, "A_")});
  EXPECT_THAT(Seqs(*Open(events, false, "A_")), ElementsAre(1));
  EXPECT_THAT(Seqs(*Open(events)), ElementsAre(0));
}

TEST_F(LogFeedTest, GoesOnBehindDamage) {
  WriteLog(path_, Concat({{RigEvent(0)}, FrameEvents(0), FrameEvents(1)}));
  std::filesystem::resize_file(path_, std::filesystem::file_size(path_) - 1);
  const auto feed = OpenLogFeed(path_, "", false, monitor_);
  EXPECT_THAT(Seqs(*feed), ElementsAre(0));
  EXPECT_THAT(log_.Lines().back(), HasSubstr("ends inside an event"));
  EXPECT_THAT(monitor_.Snapshot().last_error, HasSubstr("ends inside an event"));
  EXPECT_TRUE(feed->lacks_something());
  EXPECT_FALSE(Open(Concat({{RigEvent(0)}, FrameEvents(0)}))->lacks_something());
}

TEST_F(LogFeedTest, NamesWhatIsMissingAndWhatIsThere) {
  EXPECT_THAT(ErrorOf(FrameEvents(0)),
              AllOf(HasSubstr("capture.source = log:" + path_ + ": no SPROUT_RIG in it; it has "),
                    HasSubstr("SPROUT_LEFT (1), SPROUT_RIGHT (1), SPROUT_TOF (1)")));
  EXPECT_THAT(ErrorOf({RigEvent(0), LeftEvent(0, 50), LeftEvent(1, 50)}),
              AllOf(HasSubstr("no whole frame on SPROUT_LEFT, SPROUT_RIGHT and SPROUT_TOF in it"),
                    HasSubstr("; it has SPROUT_LEFT (2), SPROUT_RIG (1)")));
  EXPECT_THAT(ErrorOf(Concat({{RigEvent(0)}, FrameEvents(0)}), "A_"), HasSubstr("no A_SPROUT_RIG"));
  EXPECT_THAT(ErrorOf({}), HasSubstr("no events"));
  EXPECT_THAT(
      ErrorOf(FrameEvents(0, "RAW_")),
      HasSubstr("no SPROUT_RIG in it, its images are raw, ?rig=FILE rectifies them; it has RAW_"));
}

TEST_F(LogFeedTest, SaysWhyACalibrationIsUnusable) {
  TestEvent rig = RigEvent(0);
  rig.data.pop_back();
  EXPECT_THAT(ErrorOf(Concat({{rig}, FrameEvents(0)})),
              AllOf(HasSubstr("no usable SPROUT_RIG in it ("), HasSubstr("SPROUT_RIG (1)")));
}

TEST_F(LogFeedTest, NamesAFileThatIsNoLog) {
  EXPECT_THAT(Thrown<ConfigError>([&] { OpenLogFeed(folder_ / "missing", "", false, monitor_); }),
              HasSubstr("capture.source = log:" + std::string(folder_ / "missing")));
}

TEST_F(LogFeedTest, OpensFromTheConfiguration) {
  WriteLog(path_, Concat({{RigEvent(0, "A_")}, FrameEvents(0, "A_")}));
  CaptureConfig config;
  config.set_source("log:" + path_ + "?prefix=A_");
  EXPECT_THAT(Seqs(*OpenCaptureFeed(config, {}, monitor_)), ElementsAre(0));
}

}  // namespace
}  // namespace sprout::capture
