#include "services/capture/raw_source.h"

#include <gmock/gmock.h>

#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>

#include "common/bus/channels.h"
#include "common/rig/rig_file.h"
#include "services/capture/capture_feed.h"
#include "tests/common/app/captured_log.h"
#include "tests/common/app/log_files.h"
#include "tests/common/picture/temporary_directory.h"
#include "tests/common/rig/tilted_rig.h"
#include "tests/common/testing/thrown.h"
#include "tests/services/capture/raw_frame.h"

namespace sprout::capture {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class VideoTest : public ::testing::Test {
 protected:
  VideoTest() {
    RigDescription description;
    *description.mutable_calibration() = ToCalibration(TiltedRig());
    EXPECT_TRUE(SaveRigFile(rig_, description));
  }

  std::string Path(const char* name) const { return (folder_ / name).string(); }

  // `count` pictures NAME00.png, NAME01.png and so on of a grey value that tells the number.
  std::string WriteList(const std::string& name, int count, cv::Size size = {640, 480}) const {
    for (int i = 0; i < count; ++i) {
      cv::imwrite(Path((name + "0" + std::to_string(i) + ".png").c_str()),
                  Picture(size, 10 * (i + 1)));
    }
    return Path((name + "%02d.png").c_str());
  }

  CaptureConfig Config(const std::string& source) const {
    CaptureConfig config;
    config.set_source(source);
    return config;
  }

  std::string ErrorOf(const std::string& source, const FeedOptions& options = {}) {
    return Thrown<ConfigError>([&] { OpenCaptureFeed(Config(source), options, monitor_); });
  }

  static cv::Mat ImageOf(const CaptureMessages& frame, Part part) {
    for (const auto& [its, bytes] : frame.messages) {
      if (its == part) return std::get<cv::Mat>(DecodePart(part, bytes)->value);
    }
    return {};
  }

  CapturedLog log_;
  TemporaryDirectory folder_;
  std::string rig_ = Path("rig.textproto");
  StageMonitor monitor_{"capture", ""};
};

TEST_F(VideoTest, JoinsImagesOfOneNumberAndNamesTheOthers) {
  const std::string source = "opencv:" + WriteList("left", 4) + "," + WriteList("right", 5);
  std::filesystem::remove(Path("left02.png"));
  std::filesystem::remove(Path("right00.png"));
  const auto opened = OpenCameras(source, /*loop=*/false);
  for (const int number : {1, 3}) {
    const auto frame = opened.cameras->Next({}).value();
    EXPECT_EQ(frame.left.at<cv::Vec3b>(0, 0)[0], 10 * (number + 1));
    EXPECT_EQ(frame.right.at<cv::Vec3b>(0, 0)[0], 10 * (number + 1));
    EXPECT_EQ(frame.lost, number == 1 ? 3 : 0);
    if (number == 1) {
      EXPECT_THAT(frame.trouble, HasSubstr("left00.png: has no partner, nor have 2 others"));
    }
  }
  EXPECT_FALSE(opened.cameras->Next({}));
}

TEST_F(VideoTest, CountsTheOthersWithoutAPartner) {
  const auto opened =
      OpenCameras("opencv:" + WriteList("left", 2) + "," + WriteList("right", 4), /*loop=*/false);
  EXPECT_THAT(opened.cameras->Next({}).value().trouble,
              testing::EndsWith("right02.png: has no partner, nor has one other"));
}

TEST_F(VideoTest, TakesImagesOf16BitsByTheBitsThatTheyUse) {
  for (const char* name : {"left0.png", "right0.png"}) {
    cv::Mat1w image(48, 64, uint16_t{400});
    image.colRange(32, 64) = 1000;
    cv::imwrite(Path(name), image);
  }
  const std::string source = "opencv:" + Path("left%d.png") + "," + Path("right%d.png");
  EXPECT_EQ(OpenCameras(source, false).cameras->Next({})->left.at<uint8_t>(5, 5), 400 >> 2);
  EXPECT_EQ(OpenCameras(source + "?bits=12", false).cameras->Next({})->left.at<uint8_t>(5, 5),
            400 >> 4);
  EXPECT_THAT(ErrorOf(source + "?bits=7"),
              HasSubstr("cannot be used: bits=7; allowed: ?bits=8 to 16"));
}

// Pictures of a grey value that tells their time, ms / 10.
TEST_F(VideoTest, JoinsVideosOfDifferentRatesAndStartsByTime) {
  const auto write = [&](const char* name, double fps, int count, int start_ms) {
    cv::VideoWriter video(Path(name), cv::CAP_FFMPEG, cv::VideoWriter::fourcc('M', 'J', 'P', 'G'),
                          fps, {64, 48});
    ASSERT_TRUE(video.isOpened());
    for (int i = 0; i < count; ++i) {
      video.write(Picture({64, 48}, cvRound((start_ms + 1000 * i / fps) / 10)));
    }
  };
  write("left.avi", 10, 10, 0);
  write("right.avi", 30, 30, 0);
  write("late.avi", 10, 8, 200);
  const auto expect = [&](const std::string& right, int first_ms, int frames) {
    const auto opened = OpenCameras("opencv:" + Path("left.avi") + "," + right, false);
    for (int i = 0; i < frames; ++i) {
      const auto frame = opened.cameras->Next({});
      ASSERT_TRUE(frame) << right << " " << i;
      EXPECT_NEAR(frame->left.at<cv::Vec3b>(9, 9)[1], first_ms / 10 + 10 * i, 1) << right;
      EXPECT_NEAR(frame->right.at<cv::Vec3b>(9, 9)[1], first_ms / 10 + 10 * i, 1) << right;
      EXPECT_LT(frame->spread_ms, 17);
      EXPECT_EQ(frame->lost, i == 0 ? first_ms / 100 : 0);
    }
    EXPECT_FALSE(opened.cameras->Next({}));
  };
  expect(Path("right.avi"), 0, 10);
  expect(Path("late.avi") + "?offset_ms=200", 200, 8);
  EXPECT_THAT(ErrorOf("opencv:" + Path("left.avi") + "?offset_ms=x"),
              HasSubstr("cannot be used: offset_ms=x"));
}

TEST_F(VideoTest, PlaysTwoImageListsAndEndsWithTheShorterOne) {
  const std::string source = "opencv:" + WriteList("left", 3) + "," + WriteList("right", 2);
  const auto opened = OpenCameras(source, /*loop=*/false);
  EXPECT_FALSE(opened.cameras->is_live());
  EXPECT_FALSE(opened.rig);
  for (int i = 0; i < 2; ++i) {
    const auto frame = opened.cameras->Next({}).value();
    EXPECT_EQ(frame.left.at<cv::Vec3b>(0, 0)[0], 10 * (i + 1));
    EXPECT_EQ(frame.right.at<cv::Vec3b>(479, 639)[0], 10 * (i + 1));
    EXPECT_TRUE(frame.tof.depth_m.empty());
    EXPECT_EQ(frame.lost, i == 0 ? 1 : 0);
  }
  EXPECT_FALSE(opened.cameras->Next({}));
}

TEST_F(VideoTest, StartsAgainWhenAskedTo) {
  const auto opened =
      OpenCameras("opencv:" + WriteList("left", 2) + "," + WriteList("right", 2), /*loop=*/true);
  for (int i = 0; i < 5; ++i) {
    EXPECT_EQ(opened.cameras->Next({})->left.at<cv::Vec3b>(0, 0)[0], 10 * (i % 2 + 1));
  }
}

TEST_F(VideoTest, TakesBothViewsFromOnePicture) {
  cv::Mat both = Picture({1280, 480}, 20);
  both.colRange(640, 1280).setTo(cv::Scalar::all(90));
  cv::imwrite(Path("both00.png"), both);
  const auto opened = OpenCameras("opencv:" + Path("both%02d.png") + "?rig=" + rig_, false);
  ASSERT_TRUE(opened.rig);
  const auto frame = opened.cameras->Next({}).value();
  EXPECT_EQ(frame.left.size(), cv::Size(640, 480));
  EXPECT_EQ(frame.left.at<cv::Vec3b>(0, 639)[0], 20);
  EXPECT_EQ(frame.right.at<cv::Vec3b>(0, 0)[0], 90);
}

TEST_F(VideoTest, RectifiesForTheGraph) {
  const std::string source =
      "opencv:" + WriteList("left", 2) + "," + WriteList("right", 2) + "?rig=" + rig_;
  const auto feed = OpenCaptureFeed(Config(source), {}, monitor_);
  const Rectifier rectifier(TiltedRig());
  const Rig& rig = rectifier.rig();
  EXPECT_EQ(DecodePart(Part::kRig, feed->Calibration())->id.rig_id, RigId(rig));
  const auto frame = feed->Next({}).value();
  EXPECT_EQ(frame.id.rig_id, RigId(rig));
  EXPECT_EQ(ImageOf(frame, Part::kLeft).size(), rig.pair.size());
  EXPECT_TRUE(feed->Next({}));
  EXPECT_FALSE(feed->Next({}));
}

TEST_F(VideoTest, SendsRawImagesWithoutACalibration) {
  const std::string source = "opencv:" + WriteList("left", 1) + "," + WriteList("right", 1);
  const auto feed = OpenCaptureFeed(Config(source), {.raw = true}, monitor_);
  EXPECT_TRUE(feed->Calibration().empty());
  const auto frame = feed->Next({}).value();
  EXPECT_EQ(frame.id.rig_id, "");
  EXPECT_EQ(ImageOf(frame, Part::kRight).at<uchar>(3, 3), 10);
}

TEST_F(VideoTest, SaysWhatCannotBeUsed) {
  const std::string lists = "opencv:" + WriteList("left", 1) + "," + WriteList("right", 1);
  EXPECT_THAT(ErrorOf(lists), AllOf(HasSubstr("no calibration"), HasSubstr("--raw")));
  EXPECT_THAT(ErrorOf(lists + "?rig=" + Path("none")), HasSubstr("cannot be read"));
  EXPECT_THAT(ErrorOf(lists + "?rug=x"), HasSubstr("no such option rug=x"));
  EXPECT_THAT(ErrorOf(lists + "?width=-3"), HasSubstr("width=-3"));
  EXPECT_THAT(ErrorOf("opencv:"), HasSubstr("not one or two places"));
  EXPECT_THAT(ErrorOf("opencv:a,b,c"), HasSubstr("not one or two places"));
  EXPECT_THAT(ErrorOf("opencv:a,a"), HasSubstr("left and right are both a; allowed: opencv:LEFT"));
  EXPECT_THAT(ErrorOf("v4l2:a,b"), HasSubstr("not one or two places"));
  EXPECT_THAT(ErrorOf("opencv:" + Path("no.avi"), {.raw = true}),
              AllOf(HasSubstr("no.avi"), HasSubstr("cannot be opened")));
  EXPECT_THAT(ErrorOf("synthetic:64x48", {.raw = true}), HasSubstr("--raw is for cameras"));
}

TEST_F(VideoTest, EndsWhenTheSizesOfTheTwoDiffer) {
  const std::string source =
      "opencv:" + WriteList("left", 1) + "," + WriteList("right", 1, {320, 240});
  const auto opened = OpenCameras(source, false);
  EXPECT_THROW(opened.cameras->Next({}), ConfigError);
}

TEST_F(VideoTest, RefusesAListThatIsNoneOrAnImageThatIsTooLarge) {
  EXPECT_THAT(ErrorOf("opencv:" + Path("none%02d.png"), {.raw = true}),
              AllOf(HasSubstr("none%02d.png"), HasSubstr("no image is called so")));
  for (const char* name : {"a%02x.png", "a%.png", "a%2d%2d.png", "a%-2d.png", "a%99d.png"}) {
    EXPECT_THAT(ErrorOf("opencv:" + Path(name), {.raw = true}),
                AllOf(HasSubstr(name), HasSubstr("such as left_%04d.png")));
  }
  std::ofstream(Path("big00.pgm")) << "P5\n20000 20000\n255\n";
  const auto opened = OpenCameras("opencv:" + Path("big%02d.pgm"), false);
  EXPECT_THAT(Thrown<ConfigError>([&] { opened.cameras->Next({}); }),
              AllOf(HasSubstr("big00.pgm: 20000x20000 px"), HasSubstr("allowed")));
}

TEST_F(VideoTest, StartsAListWithTheFirstNumberThatIsThere) {
  for (const int number : {9, 10, 11}) {
    cv::imwrite(Path(("both" + std::to_string(number) + ".png").c_str()),
                Picture({64, 48}, number));
  }
  const auto opened = OpenCameras("opencv:" + Path("both%d.png"), false);
  for (const int number : {9, 10, 11}) {
    const auto frame = opened.cameras->Next({}).value();
    EXPECT_EQ(frame.left.at<cv::Vec3b>(0, 0)[0], number);
  }
  EXPECT_FALSE(opened.cameras->Next({}));
}

// No later frame can report what was lost at the end of a source.
TEST_F(VideoTest, CountsFramesOfAnotherSizeAtTheEndOfAList) {
  const std::string lists =
      "opencv:" + WriteList("left", 2, {64, 48}) + "," + WriteList("right", 2, {64, 48});
  const auto feed = OpenCaptureFeed(Config(lists + "?rig=" + rig_), {}, monitor_);
  EXPECT_FALSE(feed->Next({}));
  EXPECT_EQ(monitor_.Snapshot().frames_failed, 2);
  EXPECT_THAT(monitor_.Snapshot().last_error, HasSubstr("left image of 64x48"));
}

// With the rig file of a bad calibration the rig has to be calibrated again.
TEST_F(VideoTest, SendsRawImagesWhateverTheCalibrationIs) {
  RawRig rig = TiltedRig();
  rig.right.fx = 44718;
  RigDescription description;
  *description.mutable_calibration() = ToCalibration(rig);
  ASSERT_TRUE(SaveRigFile(Path("bad.textproto"), description));
  const std::string source = "opencv:" + WriteList("left", 1) + "," + WriteList("right", 1) +
                             "?rig=" + Path("bad.textproto");
  EXPECT_THAT(ErrorOf(source), AllOf(HasSubstr("bad.textproto"), HasSubstr("right.fx = 44718")));
  EXPECT_EQ(ErrorOf(source, {.raw = true}), "no error");
}

TEST_F(VideoTest, WarnsWhenRectificationKeepsLittle) {
  RawRig rig = TiltedRig();
  rig.left_from_right.rotation =
      Eigen::Quaterniond(Eigen::AngleAxisd(0.45, Eigen::Vector3d::UnitY()));
  RigDescription description;
  *description.mutable_calibration() = ToCalibration(rig);
  ASSERT_TRUE(SaveRigFile(Path("squint.textproto"), description));
  const std::string lists = "opencv:" + WriteList("left", 1) + "," + WriteList("right", 1);
  OpenCaptureFeed(Config(lists + "?rig=" + rig_), {}, monitor_);
  EXPECT_EQ(monitor_.Snapshot().last_error, "");
  OpenCaptureFeed(Config(lists + "?rig=" + Path("squint.textproto")), {}, monitor_);
  EXPECT_THAT(monitor_.Snapshot().last_error,
              AllOf(HasSubstr("the rectified images show"), HasSubstr("% of what one")));
}

class RawLogTest : public VideoTest {
 protected:
  static TestEvent Raw(int64_t seq, Part part, const PartValue& value) {
    return EventOf(seq, part, value, 10, "RAW_" + std::string(ChannelOf(part)));
  }

  std::unique_ptr<CaptureFeed> Open(const std::vector<TestEvent>& events, bool loop = false) {
    WriteLog(Path("raw.lcm"), events);
    return OpenCaptureFeed(Config("log:" + Path("raw.lcm") + "?rig=" + rig_), {.loop = loop},
                           monitor_);
  }

  std::vector<TestEvent> Frame(int64_t seq, cv::Size right = {640, 480}) const {
    const scenes::CapturedFrame frame = RawFrame(50);
    return {Raw(seq, Part::kLeft, frame.left), Raw(seq, Part::kRight, Picture(right, 50)),
            Raw(seq, Part::kTof, frame.tof)};
  }
};

// Checks what a source that rectifies sends when its rig is replaced.
void ExpectNewRigBetweenFrames(CaptureFeed& feed) {
  ASSERT_TRUE(feed.current_rig());
  const auto before = feed.Next({}).value();
  ASSERT_EQ(before.messages.size(), 3U);
  const RigInUsePtr turned = TurnedRig();
  feed.current_rig()->Replace(turned);
  EXPECT_EQ(DecodePart(Part::kRig, feed.Calibration())->id.rig_id, before.id.rig_id);

  const auto after = feed.Next({}).value();
  EXPECT_EQ(after.id.rig_id, "turned");
  ASSERT_EQ(after.messages.size(), 4U);
  EXPECT_EQ(after.messages.front().first, Part::kRig);
  const auto rig = DecodePart(Part::kRig, after.messages.front().second).value();
  EXPECT_EQ(rig.id, after.id);
  EXPECT_EQ(RigId(std::get<Rig>(rig.value)), RigId(turned->rectifier.rig()));
  EXPECT_EQ(feed.Calibration(), after.messages.front().second);
  for (size_t i = 1; i < after.messages.size(); ++i) {
    EXPECT_EQ(DecodeFrameId(after.messages[i].second)->rig_id, "turned") << i;
  }

  const auto later = feed.Next({}).value();
  EXPECT_EQ(later.id.rig_id, "turned");
  EXPECT_EQ(later.messages.size(), 3U);
}

TEST_F(VideoTest, SendsANewCalibrationBeforeTheFirstFrameThatHasIt) {
  const std::string lists = "opencv:" + WriteList("left", 3) + "," + WriteList("right", 3);
  const auto feed = OpenCaptureFeed(Config(lists + "?rig=" + rig_), {}, monitor_);
  ExpectNewRigBetweenFrames(*feed);
  EXPECT_FALSE(OpenCaptureFeed(Config(lists), {.raw = true}, monitor_)->current_rig());
}

TEST_F(RawLogTest, SendsANewCalibrationBeforeTheFirstFrameThatHasIt) {
  std::vector<TestEvent> events;
  for (int64_t seq = 0; seq < 3; ++seq) {
    for (const TestEvent& event : Frame(seq)) events.push_back(event);
  }
  ExpectNewRigBetweenFrames(*Open(events));
}

TEST_F(RawLogTest, IsRectifiedWithTheGivenRigAndKeepsItsNumbersAndTimes) {
  const auto feed = Open(Frame(4));
  EXPECT_EQ(feed->timing(), Timing::kRecorded);
  const auto frame = feed->Next({}).value();
  EXPECT_EQ(frame.id.seq, 4);
  EXPECT_EQ(frame.id.utime, TestId(4).utime);
  EXPECT_EQ(frame.id.rig_id, RigId(Rectifier(TiltedRig()).rig()));
  EXPECT_EQ(DecodePart(Part::kRig, feed->Calibration())->id, frame.id);
  EXPECT_EQ(ImageOf(frame, Part::kLeft).at<cv::Vec3b>(9, 9)[0], 50);
  EXPECT_FALSE(feed->Next({}));
}

TEST_F(RawLogTest, CountsFramesOfAnotherSize) {
  std::vector<TestEvent> events = Frame(0, {64, 48});
  const std::vector<TestEvent> good = Frame(1);
  events.insert(events.end(), good.begin(), good.end());
  const auto feed = Open(events);
  EXPECT_EQ(feed->Next({})->id.seq, 1);
  EXPECT_EQ(monitor_.Snapshot().frames_failed, 1);
  EXPECT_THAT(monitor_.Snapshot().last_error, HasSubstr("right image of 64x48"));
}

TEST_F(RawLogTest, EndsAfterARoundWithoutAnyFrameThatFits) {
  const auto none = Open(Frame(0, {64, 48}), /*loop=*/true);
  EXPECT_FALSE(none->Next({}));

  std::vector<TestEvent> events = Frame(1);
  for (const TestEvent& event : Frame(2, {64, 48})) events.push_back(event);
  const auto some = Open(events, /*loop=*/true);
  for (int round = 0; round < 4; ++round) EXPECT_EQ(some->Next({})->id.seq, 1) << round;
}

}  // namespace
}  // namespace sprout::capture
