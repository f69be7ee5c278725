#include <gmock/gmock.h>

#include <opencv2/imgcodecs.hpp>

#include "tests/services/tools/log/graph_log.h"

namespace sprout::log {
namespace {

using testing::EndsWith;
using testing::HasSubstr;
using testing::Not;

class LogDiffTest : public testing::Test {
 protected:
  MainOutcome Diff(const std::vector<Event>& a, const std::vector<Event>& b,
                   const std::vector<std::string>& flags = {}) {
    std::vector<std::string> arguments = {"diff", folder_.Write("a", a), folder_.Write("b", b)};
    arguments.insert(arguments.end(), flags.begin(), flags.end());
    MainOutcome outcome = RunLog(arguments);
    EXPECT_EQ(outcome.err, "");
    return outcome;
  }

  std::string OutOfDiff(const std::vector<Event>& a, const std::vector<Event>& b,
                        const std::vector<std::string>& flags, int exit_code = 0) {
    const MainOutcome outcome = Diff(a, b, flags);
    EXPECT_EQ(outcome.exit_code, exit_code) << outcome.out;
    return outcome.out;
  }
  std::string OutOfDiff(const std::vector<Event>& a, const std::vector<Event>& b,
                        int exit_code = 0) {
    return OutOfDiff(a, b, {}, exit_code);
  }

  LogFolder folder_;
  std::vector<Event> events_ = GraphEvents(12);
};

TEST_F(LogDiffTest, FindsALogEqualToItself) {
  EXPECT_THAT(OutOfDiff(events_, events_), EndsWith("\nequal\n"));
}

TEST_F(LogDiffTest, LooksAtNeitherTimeOfRecordingNorOrderNorStatuses) {
  std::vector<Event> other = events_;
  std::reverse(other.begin(), other.end());
  for (Event& event : other) event.utime += 12345;
  for (Event& event : other) {
    if (event.channel == kStatusChannel) event.data = StatusEvent(999).data;
  }
  EXPECT_EQ(Diff(events_, other).exit_code, 0);
  EXPECT_EQ(Diff(events_, other, {"--channels", "SPROUT_STATUS"}).exit_code, 1);
}

TEST_F(LogDiffTest, SaysWhichPixelsOfWhichFrameDiffer) {
  std::vector<Event> other = events_;
  DisparityImage changed = LogDisparity(7);
  changed.counts()(0, 5) = static_cast<int16_t>(changed.counts()(0, 5) + 48);
  changed.counts()(1, 5) = static_cast<int16_t>(changed.counts()(1, 5) - 16);
  changed.counts()(3, 9) = DisparityImage::kInvalid;
  changed.counts()(2, 0) = 32;
  EventOf(other, Part::kDisparity, 7) = PartEvent(Part::kDisparity, 7, changed);
  const std::string out = OutOfDiff(events_, other, 1);
  EXPECT_THAT(
      out,
      HasSubstr("SPROUT_DISPARITY, frame 7 (utime 1700000000700000): 4 of 768 pixels differ: "
                "2 changed (mean 1.000 px, max 1.500 px), 1 newly valid, 1 newly invalid; first at "
                "(5, 0)\n"));
  EXPECT_THAT(out, HasSubstr("first difference: SPROUT_DISPARITY, frame 7"));
  EXPECT_THAT(out, EndsWith("\ndifferent\n"));
}

TEST_F(LogDiffTest, NamesTheFirstDifferenceByFrameAndNotByChannel) {
  std::vector<Event> other = events_;
  EventOf(other, Part::kDisparity, 8) = PartEvent(Part::kDisparity, 8, LogDisparity(1));
  EventOf(other, Part::kSeeds, 5) = PartEvent(Part::kSeeds, 5, SeedSet());
  EXPECT_THAT(Diff(events_, other).out, HasSubstr("first difference: SPROUT_SEEDS, frame 5 "));
  Erase(other, Part::kTof, 2);  // which shows at the end of the logs only
  EXPECT_THAT(Diff(events_, other).out, HasSubstr("first difference: SPROUT_TOF, frame 2 "));
}

TEST_F(LogDiffTest, ComparesTheNamedChannelsOnly) {
  std::vector<Event> other = events_;
  EventOf(other, Part::kSeeds, 5) = PartEvent(Part::kSeeds, 5, SeedSet());
  EXPECT_EQ(Diff(events_, other, {"--channels", "SPROUT_SEEDS"}).exit_code, 1);
  EXPECT_EQ(
      Diff(events_, other, {"--channels", "SPROUT_PRIOR", "--channels", "SPROUT_LEFT"}).exit_code,
      0);
}

TEST_F(LogDiffTest, NamesWhatOnlyOneLogHas) {
  std::vector<Event> other = events_;
  Erase(other, Part::kDisparity, 4);
  MainOutcome outcome = Diff(events_, other);
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.out,
              HasSubstr("SPROUT_DISPARITY, frame 4 (utime 1700000000400000): only in A\n"));
  outcome = Diff(other, events_);
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.out,
              HasSubstr("SPROUT_DISPARITY, frame 4 (utime 1700000000400000): only in B\n"));
  EXPECT_THAT(outcome.out, HasSubstr("\ndifferent, but equal in what both have (--common)\n"));
  EXPECT_EQ(Diff(events_, other, {"--common"}).exit_code, 0);
  EventOf(other, Part::kDisparity, 8) = PartEvent(Part::kDisparity, 8, LogDisparity(1));
  EXPECT_THAT(Diff(events_, other).out, HasSubstr("\ndifferent\n"));
  outcome = Diff(events_, other, {"--common"});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.out, HasSubstr("first difference: SPROUT_DISPARITY, frame 8 "));
}

TEST_F(LogDiffTest, TellsOfAMissingChannelOnce) {
  std::vector<Event> other = events_;
  for (int seq = 0; seq < 12; ++seq) Erase(other, Part::kPrior, seq);
  const std::string out = OutOfDiff(events_, other, 1);
  EXPECT_THAT(
      out, HasSubstr("frame 0 (utime 1700000000000000): only in A, as all 12 of this channel\n"));
  EXPECT_THAT(out, Not(HasSubstr("frame 1 ")));
}

TEST_F(LogDiffTest, TakesAnotherEncodingForEqualAndSaysSo) {
  std::vector<Event> other = events_;
  for (int seq = 0; seq < 12; ++seq) {
    EventOf(other, Part::kPrior, seq) =
        PartEvent(Part::kPrior, seq, LogPrior(seq), DisparityEncoding::kDeltaZstd);
  }
  const std::string out = OutOfDiff(events_, other);
  EXPECT_THAT(out, HasSubstr("SPROUT_PRIOR: 12 of the equal ones are encoded differently\n"));
}

TEST_F(LogDiffTest, CountsAMessageThatCameAgainOnce) {
  std::vector<Event> other = events_;
  other.push_back(PartEvent(Part::kLeft, 11));
  const std::string out = OutOfDiff(events_, other);
  EXPECT_THAT(out, HasSubstr("in B, repeated messages with the same bytes, counted once: 1\n"));
}

TEST_F(LogDiffTest, SeesAFrameThatCameAgainWithOtherContent) {
  std::vector<Event> other = events_;
  other.push_back(PartEvent(Part::kDisparity, 11, LogDisparity(3)));
  const std::string out = OutOfDiff(events_, other, 1);
  EXPECT_THAT(out, HasSubstr("frame 11 (utime 1700000001100000), version 1: only in B\n"));
  EXPECT_EQ(Diff(other, other).exit_code, 0);
}

TEST_F(LogDiffTest, ComparesCalibrationsByContent) {
  std::vector<Event> other = events_;
  Erase(other, Part::kRig, 11);  // sent by the clock
  EXPECT_EQ(Diff(events_, other).exit_code, 0);
  Rig rig = LogRig();
  rig.pair.focal_px += 1;
  EventOf(other, Part::kRig, 1) = PartEvent(Part::kRig, 1, rig);
  const std::string out = OutOfDiff(events_, other, 1);
  EXPECT_THAT(out, HasSubstr("SPROUT_RIG, calibration cafe: calibrations differ\n"));
}

TEST_F(LogDiffTest, ComparesForeignMessagesOneByOne) {
  std::vector<Event> other = events_;
  const Event imu = {.utime = 1'700'000'000'300'000, .channel = "IMU", .data = {1, 2, 3}};
  events_.push_back(imu);
  events_.push_back(imu);
  other.push_back(imu);
  other.push_back(imu);
  EXPECT_EQ(Diff(events_, other).exit_code, 0);
  other.back().data = {1, 2, 4};
  EXPECT_THAT(OutOfDiff(events_, other, 1), HasSubstr("IMU, message 1: 3 and 3 bytes differ\n"));
}

TEST_F(LogDiffTest, ShowsSomeDifferencesOrAll) {
  std::vector<Event> other = events_;
  for (int seq = 0; seq < 12; ++seq) {
    EventOf(other, Part::kLeft, seq) = PartEvent(Part::kLeft, seq, LogValue(Part::kLeft, seq + 1));
    EventOf(other, Part::kRight, seq) =
        PartEvent(Part::kRight, seq, LogValue(Part::kRight, seq + 1));
  }
  const auto count = [](const std::string& text, const std::string& what) {
    int found = 0;
    for (size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1))
      ++found;
    return found;
  };
  const std::string some = Diff(events_, other).out;
  EXPECT_EQ(count(some, "grey levels\n"), 10 + 1);  // and the first one again
  EXPECT_THAT(some, HasSubstr("--all shows every frame"));
  const std::string all = Diff(events_, other, {"--all"}).out;
  EXPECT_EQ(count(all, "grey levels\n"), 24 + 1);
  EXPECT_EQ(count(all, ": equal\n"), 4 * 12 + 1);
}

TEST_F(LogDiffTest, WritesPicturesOfWhatDiffers) {
  std::vector<Event> other = events_;
  DisparityImage changed = LogDisparity(7);
  changed.counts().row(3) += 64;
  EventOf(other, Part::kDisparity, 7) = PartEvent(Part::kDisparity, 7, changed);
  EventOf(other, Part::kLeft, 7) =
      PartEvent(Part::kLeft, 7, cv::Mat(kLogImageSize, CV_8UC3, cv::Scalar(1, 2, 3)));
  EventOf(other, Part::kSeeds, 8) = PartEvent(Part::kSeeds, 8, SeedSet());
  const std::string pictures = folder_.File("pictures");
  const std::string out = OutOfDiff(events_, other, {"--images", pictures}, 1);
  EXPECT_THAT(out, HasSubstr(pictures + ": 6 pictures\n"));
  const auto picture = [&](const std::string& name) {
    return cv::imread(pictures + "/000007_SPROUT_" + name + ".png");
  };
  for (const std::string channel : {"DISPARITY", "LEFT"}) {
    for (const char* what : {"_a", "_b", "_difference"}) {
      EXPECT_FALSE(picture(channel + what).empty()) << channel << what;
    }
  }
  // Equal rows have the colour of 0, others another.
  const cv::Mat difference = picture("DISPARITY_difference");
  const cv::Point corner(9, 45);  // of the map in the picture, below two rows of title
  const auto color = [&](int u, int v) {
    return difference.at<cv::Vec3b>(corner + cv::Point(u, v));
  };
  EXPECT_EQ(color(10, 2), color(20, 4));
  EXPECT_NE(color(10, 3), color(10, 2));
}

TEST_F(LogDiffTest, WritesPicturesOfTheFirstDifferencesOnly) {
  std::vector<Event> other = events_;
  for (int seq = 0; seq < 12; ++seq) {
    EventOf(other, Part::kDisparity, seq) =
        PartEvent(Part::kDisparity, seq, DisparityImage(kLogImageSize));
  }
  const std::string pictures = folder_.File("pictures");
  EXPECT_THAT(Diff(events_, other, {"--images", pictures}).out, HasSubstr(": 30 pictures"));
  EXPECT_THAT(Diff(events_, other, {"--images", pictures, "--all"}).out,
              HasSubstr(": 36 pictures"));
  EXPECT_THAT(Diff(events_, events_, {"--images", pictures}).out, Not(HasSubstr("pictures")));
}

TEST_F(LogDiffTest, SurvivesADamagedLog) {
  std::vector<Event> events = events_;
  Bytes bytes = MakeLog(events);
  bytes[static_cast<size_t>(EventOf(events, Part::kSeeds, 4).offset)] ^= 1;
  WriteBytes(folder_.File("damaged"), bytes);
  const MainOutcome outcome =
      RunLog({"diff", folder_.Write("a", events_), folder_.File("damaged")});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.out,
              HasSubstr("SPROUT_SEEDS, frame 4 (utime 1700000000400000): only in A\n"));
  EXPECT_THAT(outcome.err, HasSubstr("damaged in 1 place"));
}

TEST_F(LogDiffTest, IsUnusableWithoutAnythingToCompare) {
  const auto a = folder_.Write("a", events_);
  const auto empty = folder_.Write("empty", {});
  ExpectRefused({"diff", a, a, "--channels", "SPROUT_LEFTT"}, "nothing to compare");
  ExpectRefused({"diff", a, a, "--channels", "SPROUT_LEFT,SPROUT_RIGTH"},
                "--channels SPROUT_RIGTH: neither log has an event on it");
  ExpectRefused({"diff", empty, empty}, "nothing to compare");
  ExpectRefused({"diff", a, folder_.File("none")}, "No such file");
  ExpectRefused({"diff", a}, "B is required");
}

}  // namespace
}  // namespace sprout::log
