#include <gmock/gmock.h>

#include "services/tools/calibrate/coverage.h"
#include "tests/services/tools/calibrate/board_scene.h"

namespace sprout::calibrate {
namespace {

constexpr int64_t kFrameUs = 100'000;

class ViewCollectorTest : public testing::Test {
 protected:
  RigImages At(double x_m, uint32_t seed = 0) const {
    const Pose pose{.translation_m = {-0.27 + x_m, -0.18, 1.2}};
    return scene_.Render(pose, seed);
  }

  const Board board_{BoardSize{}};
  const BoardScene scene_{board_, SceneRig({640, 480})};
  ViewCollector collector_{board_};
};

TEST_F(ViewCollectorTest, KeepsAPlaceOnce) {
  collector_.Add(At(0, 1), std::nullopt);
  collector_.Add(At(0, 2), std::nullopt);
  collector_.Add(At(0.1, 3), std::nullopt);
  collector_.Add(At(0, 4), std::nullopt);

  EXPECT_EQ(collector_.views().size(), 2);
  EXPECT_EQ(collector_.counts().images, 4);
  EXPECT_EQ(collector_.counts().similar, 2);
  EXPECT_FALSE(collector_.best_images().left.empty());
}

TEST_F(ViewCollectorTest, LeavesOutAMovingBoard) {
  collector_.Add(At(0), 1 * kFrameUs);
  collector_.Add(At(0.05), 2 * kFrameUs);  // 0.5 m/s
  collector_.Add(At(0.10), 3 * kFrameUs);
  collector_.Add(At(0.10), 4 * kFrameUs);   // stands still
  collector_.Add(At(0.05), 40 * kFrameUs);  // too long after the last image to judge motion

  EXPECT_EQ(collector_.counts().moving, 2);
  EXPECT_EQ(collector_.views().size(), 3);
}

TEST_F(ViewCollectorTest, LeavesOutImagesOfAnotherSizeAndWithoutBoard) {
  collector_.Add(At(0), std::nullopt);
  RigImages other = At(0.1);
  other.left = other.left.colRange(0, 600).clone();
  collector_.Add(other, std::nullopt);
  RigImages small_tof = At(0.1);
  small_tof.tof.depth_m = small_tof.tof.depth_m.colRange(0, 100).clone();
  collector_.Add(small_tof, std::nullopt);
  RigImages empty = At(0.1);
  empty.left.setTo(80);
  empty.right.setTo(80);
  collector_.Add(empty, std::nullopt);

  EXPECT_EQ(collector_.counts().two_sizes, 1);
  EXPECT_EQ(collector_.counts().other_size, 1);
  EXPECT_EQ(collector_.counts().no_board, 1);
  EXPECT_EQ(collector_.counts().foreign, 0);
  EXPECT_EQ(collector_.views().size(), 1);
}

TEST_F(ViewCollectorTest, TakesTheSizeOfTheFirstViewNotOfAStrayFrame) {
  const cv::Mat1b wall(16, 20, uchar{80});
  const RigImages stray{.left = wall, .right = wall, .tof = {}};
  collector_.Add(stray, std::nullopt);
  collector_.Add(At(0), std::nullopt);
  collector_.Add(stray, std::nullopt);

  EXPECT_EQ(collector_.views().size(), 1);
  EXPECT_EQ(collector_.sizes()[kLeft], cv::Size(640, 480));
  EXPECT_EQ(collector_.sizes()[kTof], cv::Size(176, 144));
  EXPECT_EQ(collector_.counts().no_board, 1);
  EXPECT_EQ(collector_.counts().other_size, 1);
}

TEST_F(ViewCollectorTest, NoticesThatItIsAnotherBoard) {
  ViewCollector collector(Board({.columns = 5, .rows = 7, .square_m = 0.06}));
  for (const double x_m : {-0.05, 0., 0.05}) collector.Add(At(x_m), std::nullopt);

  EXPECT_EQ(collector.counts().no_board, 3);
  EXPECT_EQ(collector.counts().foreign, 3);
}

}  // namespace
}  // namespace sprout::calibrate
