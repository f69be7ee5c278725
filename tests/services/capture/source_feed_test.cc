#include "services/capture/source_feed.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/messages/codec.h"
#include "services/capture/dataset.h"
#include "tests/services/capture/kitti_folder.h"
#include "tests/services/capture/scene_folder.h"

namespace sprout {
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

TEST(SourceFeed, NumbersAndStampsTheFramesOfItsSource) {
  const auto feed = OpenSourceFeed(Synthetic(), /*loop=*/false);
  const auto source = OpenDataset(Synthetic());
  EXPECT_FALSE(feed->is_recorded());
  int64_t newest_utime = NowUtime() - 1;
  for (int64_t seq = 0; seq < 3; ++seq) {
    const auto frame = feed->Next();
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->id.seq, seq);
    EXPECT_GT(frame->id.utime, newest_utime);
    EXPECT_EQ(frame->id.rig_id, RigId(source->rig()));
    ASSERT_EQ(frame->messages.size(), 3U);
    EXPECT_EQ(frame->messages[2].first, Part::kTof);
    EXPECT_EQ(cv::norm(ImageOf(*frame, 0), source->Get(seq).left), 0);
    newest_utime = frame->id.utime;
  }
}

TEST(SourceFeed, EndsWithItsSourceUnlessItLoops) {
  const SceneFolder scene;
  scene.Write2005({30, 20});
  const auto once = OpenSourceFeed(scene.Config(), /*loop=*/false);
  EXPECT_TRUE(once->Next());
  EXPECT_FALSE(once->Next());
  const auto looping = OpenSourceFeed(scene.Config(), /*loop=*/true);
  for (int64_t seq = 0; seq < 3; ++seq) EXPECT_EQ(looping->Next()->id.seq, seq);
}

TEST(SourceFeed, SendsColourAsConfigured) {
  CaptureConfig config = Synthetic();
  EXPECT_EQ(ImageOf(*OpenSourceFeed(config, false)->Next(), 0).channels(), 3);
  EXPECT_EQ(ImageOf(*OpenSourceFeed(config, false)->Next(), 1).channels(), 1);
  config.set_left_in_colour(false);
  config.set_right_in_colour(true);
  EXPECT_EQ(ImageOf(*OpenSourceFeed(config, false)->Next(), 0).channels(), 1);
  EXPECT_EQ(ImageOf(*OpenSourceFeed(config, false)->Next(), 1).channels(), 3);
}

// The stages wait for the message, whether or not there is a ToF camera.
TEST(SourceFeed, SendsAToFMessageWithoutAToFCamera) {
  const KittiFolder kitti;
  kitti.WriteStereo("000000");
  const auto frame = OpenSourceFeed(kitti.Config("/000000?tof=none"), /*loop=*/false)->Next();
  ASSERT_TRUE(frame);
  ASSERT_EQ(frame->messages.size(), 3U);
  const auto& [part, bytes] = frame->messages[2];
  EXPECT_EQ(part, Part::kTof);
  EXPECT_TRUE(std::get<TofImage>(DecodePart(part, bytes)->value).depth_m.empty());
}

TEST(SourceFeed, NamesItsCalibrationByTheNewestFrame) {
  const auto feed = OpenSourceFeed(Synthetic(), false);
  const auto id_of = [](const std::vector<uint8_t>& rig) {
    return DecodePart(Part::kRig, rig)->id;
  };
  EXPECT_EQ(id_of(feed->Calibration()).seq, 0) << "before the first frame";
  const FrameId first = feed->Next()->id;
  EXPECT_EQ(id_of(feed->Calibration()), first);
  const FrameId second = feed->Next()->id;
  EXPECT_EQ(id_of(feed->Calibration()), second);
}

}  // namespace
}  // namespace sprout
