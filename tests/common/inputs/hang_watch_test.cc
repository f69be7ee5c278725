#include "common/inputs/hang_watch.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sprout::inputs {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

struct Changes {
  bool left = false, right = false, ranges = false;
};

class HangWatchTest : public ::testing::Test {
 protected:
  HangWatchTest() {
    frame_.left = cv::Mat1b(40, 30, uint8_t{0});
    frame_.right = frame_.left.clone();
    frame_.tof = TofImage{.depth_m = cv::Mat1f(4, 3, 0.F), .amplitude = {}};
  }

  // What is said of so many frames in which these images change.
  std::string Play(int frames, Changes changes) {
    std::string said;
    for (int i = 0; i < frames; ++i) {
      ++seq_;
      if (changes.left) frame_.left.at<uint8_t>(39, 29) = static_cast<uint8_t>(seq_);
      if (changes.right) frame_.right.at<uint8_t>(39, 29) = static_cast<uint8_t>(seq_);
      if (changes.ranges) frame_.tof->depth_m(3, 2) = static_cast<float>(seq_);
      said += watch_.Add(frame_);
    }
    return said;
  }

  HangWatch watch_;
  Frame frame_;
  int seq_ = 0;
};

TEST_F(HangWatchTest, StillsDoNotHangWhetherTheirRangesHaveNoiseOrNot) {
  EXPECT_EQ(Play(25, {}), "");
  EXPECT_EQ(Play(25, {.ranges = true}), "");
}

TEST_F(HangWatchTest, NamesACameraBesideWhichTheOtherOneChanges) {
  EXPECT_EQ(Play(9, {.right = true, .ranges = true}), "");
  EXPECT_THAT(Play(1, {.right = true, .ranges = true}), StartsWith("10 left images in a row"));
  EXPECT_THAT(Play(10, {.right = true, .ranges = true}), StartsWith("20 left images in a row"));
}

TEST_F(HangWatchTest, NamesARangeSensorBesideWhichPicturesChange) {
  EXPECT_THAT(Play(10, {.left = true, .right = true}), StartsWith("10 range images in a row"));
  frame_.tof->depth_m.release();
  EXPECT_EQ(Play(20, {.left = true, .right = true}), "") << "none come";
}

TEST_F(HangWatchTest, NamesBothCamerasThatChangedBefore) {
  EXPECT_EQ(Play(3, {.left = true, .right = true, .ranges = true}), "");
  EXPECT_THAT(Play(9, {.ranges = true}), HasSubstr("10 left, 10 right images in a row"));
  EXPECT_EQ(Play(1, {.left = true, .right = true, .ranges = true}), "") << "over";
  EXPECT_THAT(Play(9, {}), HasSubstr("10 left, 10 right, 10 range images in a row"));
  frame_.id.rig_id = "of the next still";
  EXPECT_EQ(Play(20, {}), "");
}

TEST(RepeatWatch, NamesTheImageThatStaysWhileTheOtherViewMoves) {
  cv::Mat1b view(40, 60);
  cv::randu(view, 0, 255);
  const auto turned = [&](int columns) { return view.colRange(columns, columns + 50).clone(); };
  RepeatWatch watch;
  EXPECT_EQ(watch.Add(turned(0), turned(2)), "");
  EXPECT_EQ(watch.Add(turned(3), turned(5)), "");
  EXPECT_THAT(watch.Add(turned(3), turned(8)), StartsWith("the left image is that of the pair be"));
  EXPECT_THAT(watch.Add(turned(6), turned(8)), StartsWith("the right image is that of the pair "));
  EXPECT_EQ(watch.Add(turned(6), turned(8)), "") << "neither moves";
  EXPECT_EQ(watch.Add(turned(6), turned(8) + 3), "") << "noise of a compressed still";
  EXPECT_EQ(watch.Add(turned(6), view), "") << "another size";
  const cv::Mat1b covered(40, 50, uint8_t{3});
  EXPECT_EQ(watch.Add(covered, turned(2)), "");
  EXPECT_EQ(watch.Add(covered, turned(5)), "") << "dark";
}

}  // namespace
}  // namespace sprout::inputs
