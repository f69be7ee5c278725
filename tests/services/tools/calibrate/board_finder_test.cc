#include "services/tools/calibrate/board_finder.h"

#include <gmock/gmock.h>

#include <opencv2/imgproc.hpp>

#include "tests/services/tools/calibrate/board_scene.h"

namespace sprout::calibrate {
namespace {

class BoardFinder : public testing::Test {
 protected:
  // Root of the mean square of a coordinate's error, px.
  static double Rms(const BoardCorners& found, const BoardCorners& truth) {
    double sum = 0;
    for (size_t i = 0; i < found.ids.size(); ++i) {
      const auto place = std::ranges::find(truth.ids, found.ids[i]) - truth.ids.begin();
      const cv::Point2d error = found.pixels[i] - truth.pixels[static_cast<size_t>(place)];
      sum += error.dot(error) / 2;
    }
    return std::sqrt(sum / found.size());
  }

  const Board board_{BoardSize{}};
  const BoardScene scene_{board_, SceneRig({1024, 768})};
  const std::vector<Pose> poses_ = BoardPoses(board_, 4);
};

TEST_F(BoardFinder, FindsCornersToAFewHundredthsOfAPixel) {
  for (uint32_t i = 0; i < poses_.size(); ++i) {
    const BoardCorners truth = scene_.Project(poses_[i], 0, 0).corners[kLeft];
    const BoardCorners found = FindBoard(board_, scene_.Render(poses_[i], i).left);

    EXPECT_GE(found.size(), 24) << i;
    EXPECT_LT(Rms(found, truth), 0.08) << i;
  }
}

TEST_F(BoardFinder, FindsCornersInSr4000Amplitudes) {
  const RigImages images = scene_.Render(poses_[0], 1);
  const BoardCorners truth = scene_.Project(poses_[0], 0, 0).corners[kTof];

  const BoardCorners found = FindBoardInAmplitude(board_, images.tof.amplitude);

  EXPECT_GE(found.size(), 20);
  EXPECT_LT(Rms(found, truth), 0.2);
}

TEST_F(BoardFinder, FindsCornersWhereTheyAreExpected) {
  const RigImages images = scene_.Render(poses_[0], 1);
  const BoardCorners truth = scene_.Project(poses_[0], 0, 0).corners[kTof];
  BoardCorners expected = truth;
  for (cv::Point2d& pixel : expected.pixels) pixel += cv::Point2d(1, -1);

  const BoardCorners found = FindCornersNear(board_, expected, images.tof.amplitude);

  EXPECT_GE(found.size(), 0.9 * truth.size());
  EXPECT_LT(Rms(found, truth), 0.2);
}

TEST_F(BoardFinder, FindsNothingWhereThereIsNoBoard) {
  cv::Mat1b noise(480, 640);
  cv::RNG(1).fill(noise, cv::RNG::UNIFORM, 0, 256);
  EXPECT_EQ(FindBoard(board_, noise).size(), 0);
  EXPECT_EQ(FindBoard(board_, cv::Mat1b(480, 640, uchar{128})).size(), 0);
  EXPECT_EQ(FindBoardInAmplitude(board_, {}).size(), 0);
  EXPECT_EQ(FindBoardInAmplitude(board_, cv::Mat1f(144, 176, 0.F)).size(), 0);
  EXPECT_EQ(FindBoardInAmplitude(board_, cv::Mat1f(144, 176, std::nanf(""))).size(), 0);

  // Expected, but not there.
  const BoardCorners expected = scene_.Project(poses_[0], 0, 0).corners[kTof];
  cv::Mat1f flat(144, 176);
  cv::RNG(2).fill(flat, cv::RNG::NORMAL, 1000, 1);
  cv::GaussianBlur(flat, flat, {}, 2);
  flat(0, 0) = 5000;
  EXPECT_LT(FindCornersNear(board_, expected, flat).size(), expected.size() / 4);
}

TEST_F(BoardFinder, KnowsWhichCornersItSeesOfAPart) {
  const RigImages images = scene_.Render(poses_[0], 1);
  const BoardCorners truth = scene_.Project(poses_[0], 0, 0).corners[kLeft];
  cv::Mat1b part = images.left.clone();
  part.colRange(0, 512).setTo(90);

  const BoardCorners found = FindBoard(board_, part);

  EXPECT_GE(found.size(), 8);
  EXPECT_LT(found.size(), truth.size());
  EXPECT_LT(Rms(found, truth), 0.05);
}

}  // namespace
}  // namespace sprout::calibrate
