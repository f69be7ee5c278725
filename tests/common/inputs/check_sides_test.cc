#include <gmock/gmock.h>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "tests/common/inputs/parts.h"

namespace sprout::inputs {
namespace {

using testing::HasSubstr;

TEST(CheckInputs, SaysThatLeftAndRightAreSwapped) {
  Parts parts = SceneOf();
  std::swap(parts.left, parts.right);
  ExpectBad(parts, Question::kSides, "swapped");
  EXPECT_EQ(parts.Answer(Question::kScene).verdict, Verdict::kGood);
}

TEST(CheckInputs, SaysByRangesThatSidesAreSwappedWherePrincipalPointsHideIt) {
  // Principal points so far apart that all disparities are positive, swapped or not.
  Parts parts = SceneOf();
  constexpr double kApartPx = 200;
  cv::Mat1b moved(parts.right.size(), uint8_t{0});
  cv::warpAffine(parts.right, moved, cv::Matx23d(1, 0, kApartPx, 0, 1, 0), parts.right.size());
  parts.right = moved;
  parts.rig.pair.cx_right += kApartPx;
  EXPECT_EQ(parts.Answer(Question::kSides).verdict, Verdict::kGood);
  std::swap(parts.left, parts.right);
  EXPECT_EQ(parts.Answer(Question::kSides).verdict, Verdict::kBad);
}

// Each fault hides the other one.
TEST(CheckInputs, SaysThatColumnsLieAsideOfRangesThatAreWrong) {
  Parts parts = Moved(cv::Matx23d(1, 0, -20, 0, 1, 0));
  ExpectBad(parts, Question::kSides, "px further left than ranges say (then");
  Parts mirrored = parts;
  mirrored.tof.depth_m = cv::Mat1f();
  cv::flip(parts.tof.depth_m, mirrored.tof.depth_m, 1);
  ExpectBad(mirrored, Question::kSides, "px further left than ranges say, which are turned");
  parts.tof.depth_m *= 0.256;
  ExpectBad(parts, Question::kSides, "px further left than ranges say, which are in another unit");
  parts.right = SceneOf().right;
  EXPECT_NE(parts.Answer(Question::kSides).verdict, Verdict::kBad);
}

// Bright boards, of 30 px of disparity, before a dark wall of 12 px.
Parts BoardsBeforeAWall() {
  const cv::Size size(480, 360);
  constexpr int kWall = 12, kBoard = 30, kWide = 600;
  const auto texture = [&](int mean) {
    cv::Mat1b pixels(size.height, kWide);
    cv::RNG random(static_cast<uint64_t>(mean));
    random.fill(pixels, cv::RNG::UNIFORM, mean - 40, mean + 40);
    cv::GaussianBlur(pixels, pixels, {}, 1.2);
    return pixels;
  };
  const cv::Mat1b wall = texture(70), board = texture(170);
  Parts parts = {.left = cv::Mat1b(size), .right = cv::Mat1b(size), .tof = {}, .rig = {}};
  wall(cv::Rect({kWall, 0}, size)).copyTo(parts.left);
  wall(cv::Rect({2 * kWall, 0}, size)).copyTo(parts.right);
  for (const int u : {60, 190, 330}) {
    const cv::Rect place(u, 20 + u / 3, 80, 160);
    board(place).copyTo(parts.left(place));
    board(place).copyTo(parts.right(place - cv::Point(kBoard, 0)));
  }
  parts.rig.pair.width = size.width;
  parts.rig.pair.height = size.height;
  parts.rig.pair.focal_px = 400;
  parts.rig.pair.baseline_m = 0.1;
  parts.rig.pair.cx = 239.5;
  parts.rig.pair.cx_right = 339.5;  // disparities from -100 on
  parts.rig.pair.cy = 179.5;
  return parts;
}

TEST(CheckInputs, SaysByWhatOccludesThatSidesAreSwappedWherePrincipalPointsHideIt) {
  Parts parts = BoardsBeforeAWall();
  const Finding right = parts.Answer(Question::kSides);
  EXPECT_EQ(right.verdict, Verdict::kGood) << right.text;
  std::swap(parts.left, parts.right);
  const Finding swapped = parts.Answer(Question::kSides);
  EXPECT_EQ(swapped.verdict, Verdict::kBad) << swapped.text;
  EXPECT_THAT(swapped.text, HasSubstr("left and right are swapped"));
  std::swap(parts.left, parts.right);
  for (cv::Mat1b* image : {&parts.left, &parts.right}) cv::flip(*image, *image, 1);
  EXPECT_EQ(parts.Answer(Question::kSides).verdict, Verdict::kBad);
}

TEST(CheckInputs, TellsSidesByWhatOccludesWhateverTheExposure) {
  Parts parts = BoardsBeforeAWall();
  for (const auto& [gain, offset] : {std::pair{0.7, 0}, {0.9, 25}}) {
    parts.right.convertTo(parts.right, CV_8U, gain, offset);
    const Finding finding = parts.Answer(Question::kSides);
    EXPECT_EQ(finding.verdict, Verdict::kGood) << finding.text;
  }
}

// One plane: nothing occludes.
TEST(CheckInputs, CannotTellSidesWherePrincipalPointsHideThemAndNothingOccludes) {
  Parts parts = SceneOf("synthetic:640x480?tof=none");
  cv::Mat1b moved;
  cv::warpAffine(parts.left, moved, cv::Matx23d(1, 0, -20, 0, 1, 0), parts.left.size());
  parts.right = moved;
  parts.rig.pair.cx_right += 400;
  const Finding finding = parts.Answer(Question::kSides);
  EXPECT_EQ(finding.verdict, Verdict::kCannotTell) << finding.text;
}

TEST(CheckInputs, SaysThatOneFileIsGivenTwice) {
  Parts parts = SceneOf();
  parts.right = parts.left;
  EXPECT_THAT(parts.Answer(Question::kSides).text, HasSubstr("same picture"));
  // Not byte by byte: one of them was compressed again.
  cv::Mat1b noise(parts.left.size());
  cv::RNG(2).fill(noise, cv::RNG::UNIFORM, 0, 5);
  parts.right = parts.left + noise;
  ExpectBad(parts, Question::kSides, "same picture");
  std::vector<uint8_t> jpeg;
  cv::imencode(".jpg", parts.left, jpeg, {cv::IMWRITE_JPEG_QUALITY, 10});
  parts.right = cv::imdecode(jpeg, cv::IMREAD_GRAYSCALE);
  ExpectBad(parts, Question::kSides, "same picture");
}

}  // namespace
}  // namespace sprout::inputs
