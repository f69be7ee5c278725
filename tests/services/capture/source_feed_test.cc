#include "services/capture/source_feed.h"

#include <gmock/gmock.h>

#include <deque>

#include "common/messages/codec.h"
#include "common/messages/packed.h"
#include "common/scenes/dataset.h"
#include "services/capture/image_encoder.h"
#include "tests/common/app/captured_log.h"
#include "tests/common/messages/examples.h"
#include "tests/common/scenes/kitti_folder.h"
#include "tests/common/scenes/scene_folder.h"

namespace sprout::capture {
namespace {

CaptureConfig Synthetic() {
  CaptureConfig config;
  config.set_source("synthetic:64x48");
  return config;
}

cv::Mat ImageOf(const CaptureMessages& frame, size_t index) {
  return std::get<cv::Mat>(
      DecodePart(frame.messages[index].first, frame.messages[index].second)->value);
}

class SourceFeed : public ::testing::Test {
 protected:
  std::unique_ptr<CaptureFeed> Open(const CaptureConfig& config, bool loop = false) {
    return OpenCaptureFeed(config, {.loop = loop}, monitor_);
  }

  CapturedLog log_;
  StageMonitor monitor_{"capture", ""};
};

TEST_F(SourceFeed, NumbersAndStampsTheFramesOfItsSource) {
  const auto feed = Open(Synthetic());
  const auto source = scenes::OpenDataset(Synthetic());
  EXPECT_EQ(feed->timing(), Timing::kAsked);
  int64_t newest_utime = NowUtime() - 1;
  for (int64_t seq = 0; seq < 3; ++seq) {
    const auto frame = feed->Next({}).value();
    EXPECT_EQ(frame.id.seq, seq);
    EXPECT_GT(frame.id.utime, newest_utime);
    EXPECT_EQ(frame.id.rig_id, RigId(source->rig()));
    ASSERT_EQ(frame.messages.size(), 3U);
    EXPECT_EQ(frame.messages[2].first, Part::kTof);
    EXPECT_EQ(cv::norm(ImageOf(frame, 0), source->Get(seq).left), 0);
    newest_utime = frame.id.utime;
  }
}

TEST_F(SourceFeed, EndsWithItsSourceUnlessItLoops) {
  const scenes::SceneFolder scene(cv::Size(30, 20));
  const auto once = Open(scene.Config());
  EXPECT_TRUE(once->Next({}));
  EXPECT_FALSE(once->Next({}));
  const auto looping = Open(scene.Config(), /*loop=*/true);
  for (int64_t seq = 0; seq < 3; ++seq) EXPECT_EQ(looping->Next({})->id.seq, seq);
}

TEST_F(SourceFeed, SendsColourAsConfigured) {
  CaptureConfig config = Synthetic();
  EXPECT_EQ(ImageOf(*Open(config)->Next({}), 0).channels(), 3);
  EXPECT_EQ(ImageOf(*Open(config)->Next({}), 1).channels(), 1);
  config.set_left_in_colour(false);
  EXPECT_EQ(ImageOf(*Open(config)->Next({}), 0).channels(), 1);
  EXPECT_EQ(ImageOf(*Open(config)->Next({}), 1).channels(), 1);
}

// The stages wait for the message, whether or not there is a ToF camera.
TEST_F(SourceFeed, SendsAToFMessageWithoutAToFCamera) {
  const scenes::KittiFolder kitti("000000");
  const auto frame = Open(kitti.Config("/000000?tof=none"))->Next({}).value();
  ASSERT_EQ(frame.messages.size(), 3U);
  const auto& [part, bytes] = frame.messages[2];
  EXPECT_EQ(part, Part::kTof);
  EXPECT_TRUE(std::get<TofImage>(DecodePart(part, bytes)->value).depth_m.empty());
}

TEST_F(SourceFeed, NamesItsCalibrationByTheNewestFrame) {
  const auto feed = Open(Synthetic());
  const auto id_of = [](const std::vector<uint8_t>& rig) {
    return DecodePart(Part::kRig, rig)->id;
  };
  EXPECT_EQ(id_of(feed->Calibration()).seq, 0) << "before the first frame";
  const FrameId first = feed->Next({})->id;
  EXPECT_EQ(id_of(feed->Calibration()), first);
  const FrameId second = feed->Next({})->id;
  EXPECT_EQ(id_of(feed->Calibration()), second);
}

// A camera that stamps its frames, and loses some; or a recording of it.
class Camera : public scenes::FrameSource {
 public:
  explicit Camera(bool is_live, std::deque<int64_t> times = {5000, 4000, 9000})
      : is_live_(is_live), times_(std::move(times)) {}

  const Rig& rig() const override { return rig_; }
  bool is_live() const override { return is_live_; }
  bool is_recorded() const override { return !is_live_; }
  std::optional<scenes::CapturedFrame> Next(const std::stop_token& /*stop*/) override {
    scenes::CapturedFrame frame;
    frame.left = cv::Mat(2, 3, CV_8UC1, cv::Scalar(1));
    frame.right = cv::Mat(2, 3, CV_8UC1, cv::Scalar(2));
    frame.utime = times_.front();
    times_.pop_front();
    frame.lost = 2;
    frame.trouble = "packets lost";
    return frame;
  }

 private:
  Rig rig_ = examples::Rig();
  bool is_live_;
  std::deque<int64_t> times_;
};

TEST_F(SourceFeed, StampsFramesWithTheTimeOfTheirExposureAndCountsWhatWasLost) {
  const auto feed = FeedFrom(std::make_unique<Camera>(true), CaptureConfig(), monitor_);
  EXPECT_EQ(feed->timing(), Timing::kLive);
  EXPECT_EQ(feed->Next({})->id.utime, 5000);
  EXPECT_EQ(feed->Next({})->id.utime, 5001) << "clock set back";
  EXPECT_EQ(feed->Next({})->id.utime, 9000);
  EXPECT_EQ(monitor_.Snapshot().frames_failed, 6);
  EXPECT_THAT(monitor_.Snapshot().last_error, ::testing::HasSubstr("packets lost"));
}

class UnstampedCamera : public Camera {
 public:
  UnstampedCamera() : Camera(true) {}
  std::optional<scenes::CapturedFrame> Next(const std::stop_token& stop) override {
    std::optional<scenes::CapturedFrame> frame = Camera::Next(stop);
    frame->utime.reset();
    frame->lost = 0;
    frame->trouble.clear();
    return frame;
  }
};

TEST_F(SourceFeed, SaysThatTheClockWhichStampsFramesWasSetBack) {
  int64_t now = 5'000'000;
  const auto feed = FeedFrom(std::make_unique<UnstampedCamera>(), CaptureConfig(), monitor_,
                             nullptr, [&] { return now; });
  EXPECT_EQ(feed->Next({})->id.utime, 5'000'000);
  EXPECT_EQ(monitor_.Snapshot().last_error, "");
  now = 4'500'000;
  EXPECT_EQ(feed->Next({})->id.utime, 5'000'001);
  EXPECT_EQ(monitor_.Snapshot().last_error,
            "this host's clock was set back by 0.500 s: until it is there again, frames are "
            "stamped 1 µs apart");
}

TEST_F(SourceFeed, OneStampThatIsADayAheadIsTheOnlyWrongOne) {
  const std::deque<int64_t> times = {1'000'000, 1'100'000, 86'400'000'000, 1'300'000, 1'400'000};
  const auto feed = FeedFrom(std::make_unique<Camera>(true, times), CaptureConfig(), monitor_);
  for (const int64_t utime : times) EXPECT_EQ(feed->Next({})->id.utime, utime);
  EXPECT_THAT(log_.Lines(), ::testing::Contains(::testing::HasSubstr(
                                "the cameras' clock was set back by 86398.700 s: the times of "
                                "frames go back, too")));
}

TEST_F(SourceFeed, GivesARecordingThatBeginsAgainItsOwnTimesAgain) {
  const std::deque<int64_t> times = {5000, 7000, 7000, 8000, 5000, 7000, 7000};
  const auto feed = FeedFrom(std::make_unique<Camera>(false, times), CaptureConfig(), monitor_);
  EXPECT_EQ(feed->timing(), Timing::kRecorded);
  std::vector<int64_t> sent;
  for (int64_t seq = 0; seq < std::ssize(times); ++seq) {
    const FrameId id = feed->Next({})->id;
    EXPECT_EQ(id.seq, seq);
    sent.push_back(id.utime);
  }
  EXPECT_THAT(sent, ::testing::ElementsAre(5000, 7000, 7001, 8000, 5000, 7000, 7001));
}

// Its right camera hangs from the second frame to the 14th.
class HangingCamera : public Camera {
 public:
  explicit HangingCamera(bool is_live)
      : Camera(is_live, {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16}) {}

  std::optional<scenes::CapturedFrame> Next(const std::stop_token& stop) override {
    std::optional<scenes::CapturedFrame> frame = Camera::Next(stop);
    frame->trouble.clear();
    frame->lost = 0;
    frame->left.row(1) = cv::Scalar(++count_);
    frame->right = cv::Scalar(count_ == 1 || count_ > 14 ? count_ : 2);
    return frame;
  }

 private:
  int count_ = 0;
};

TEST_F(SourceFeed, SaysThatALiveCameraGivesTheSameImageAgainAndAgain) {
  for (const bool is_live : {true, false}) {
    const auto feed = FeedFrom(std::make_unique<HangingCamera>(is_live), CaptureConfig(), monitor_);
    for (int i = 1; i <= 16; ++i) {
      ASSERT_TRUE(feed->Next({}));
      const bool is_frozen = is_live && i >= 11 && i <= 14;
      EXPECT_EQ(monitor_.Snapshot().last_error,
                is_frozen ? "the right camera gives the same image again and again, bit for bit: "
                            "it hangs, or sees nothing"
                          : "")
          << i;
    }
  }
}

class ImageEncoderTest : public testing::Test {
 protected:
  ImageEncoderTest() {
    config_.set_source("synthetic:160x120");
    const auto dataset = scenes::OpenDataset(config_);
    const scenes::DatasetFrame captured = dataset->Get(0);
    raw_.id = {.utime = 5, .seq = 7, .rig_id = "rig"};
    const std::pair<Part, PartValue> parts[] = {
        {Part::kLeft, captured.left}, {Part::kRight, captured.right}, {Part::kTof, captured.tof}};
    for (const auto& [part, value] : parts) {
      raw_.messages.emplace_back(part, EncodePart(raw_.id, part, value));
    }
  }

  CaptureMessages Encoded(CaptureConfig::ImageEncoding encoding) {
    config_.set_image_encoding(encoding);
    CaptureMessages frame = raw_;
    ImageEncoder(config_).Encode(frame);
    return frame;
  }

  CaptureConfig config_;
  CaptureMessages raw_;
};

TEST_F(ImageEncoderTest, LosesNothingUnlessItMay) {
  const CaptureMessages frame = Encoded(CaptureConfig::LOSSLESS);
  for (size_t i = 0; i < 2; ++i) {
    EXPECT_LT(10 * frame.messages[i].second.size(), 7 * raw_.messages[i].second.size());
    EXPECT_EQ(*Unpack(frame.messages[i].second), raw_.messages[i].second);
  }
  EXPECT_EQ(frame.messages[2], raw_.messages[2]);
}

TEST_F(ImageEncoderTest, MakesJpegOfTheQualityThatIsAskedFor) {
  const CaptureMessages good = Encoded(CaptureConfig::JPEG);
  config_.set_jpeg_quality(30);
  const CaptureMessages small = Encoded(CaptureConfig::JPEG);
  for (size_t i = 0; i < 2; ++i) {
    const auto& [part, bytes] = good.messages[i];
    EXPECT_LT(10 * bytes.size(), 3 * raw_.messages[i].second.size());
    EXPECT_LT(small.messages[i].second.size(), bytes.size());
    const auto image = std::get<cv::Mat>(DecodePart(part, bytes)->value);
    const auto before = std::get<cv::Mat>(DecodePart(part, raw_.messages[i].second)->value);
    EXPECT_GT(cv::PSNR(image, before), 28);
  }
  EXPECT_EQ(good.messages[2], raw_.messages[2]);
}

}  // namespace

}  // namespace sprout::capture
