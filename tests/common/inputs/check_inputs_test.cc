#include "common/inputs/check_inputs.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "common/scenes/tof_grid.h"
#include "tests/common/core/centred.h"
#include "tests/common/inputs/parts.h"

namespace sprout::inputs {
namespace {

using testing::HasSubstr;

TEST(CheckInputs, FindsNothingBadInAGoodFrame) {
  for (const char* source : {"synthetic:640x480?tof=grid", "synthetic:640x480?tof=sr4000",
                             "synthetic:320x240?tof=grid", "synthetic:1600x1200?tof=grid"}) {
    for (const Finding& finding : SceneOf(source).Check()) {
      EXPECT_EQ(finding.verdict, Verdict::kGood)
          << source << ": " << NameOf(finding.question) << ": " << finding.text;
    }
  }
}

TEST(CheckInputs, SaysThatTwoScenesAreNotOne) {
  Parts parts = SceneOf();
  cv::Mat1b noise(parts.right.size());
  cv::RNG random(1);
  random.fill(noise, cv::RNG::UNIFORM, 0, 256);
  cv::GaussianBlur(noise, noise, {}, 1.5);
  cv::normalize(noise, parts.right, 0, 255, cv::NORM_MINMAX);
  ExpectBad(parts, Question::kScene, "do not show one scene");
  EXPECT_EQ(parts.Answer(Question::kRows).verdict, Verdict::kCannotTell);
}

TEST(CheckInputs, SeesOneSceneThroughNoiseAndBlur) {
  cv::RNG random(1);
  const auto add_noise = [&](cv::Mat1b& image) {
    cv::Mat1s noise(image.size());
    random.fill(noise, cv::RNG::NORMAL, 0, 40);
    cv::add(image, noise, image, {}, CV_8U);
  };
  Parts parts = Moved({1, 0, 0, 0, 1, 4});
  add_noise(parts.left);
  add_noise(parts.right);
  EXPECT_EQ(parts.Answer(Question::kScene).verdict, Verdict::kGood);
  EXPECT_NEAR(parts.Answer(Question::kRows).value, 4, 1);
  parts = SceneOf();
  cv::GaussianBlur(parts.right, parts.right, {}, 4);
  EXPECT_EQ(parts.Answer(Question::kScene).verdict, Verdict::kGood);
}

TEST(CheckInputs, SaysThatAnImageIsBlank) {
  Parts parts = SceneOf();
  parts.right = cv::Mat1b(parts.right.size(), uint8_t{128});
  ExpectBad(parts, Question::kBits, "right image is blank");
}

TEST(CheckInputs, SaysThatImagesAreRawMosaics) {
  const Parts scene = SceneOf();
  // As a scene whose green is brighter than its red and blue.
  const auto behind_filter = [](cv::Mat1b& image) {
    for (int y = 0; y < image.rows; ++y) {
      for (int x = y % 2; x < image.cols; x += 2) image(y, x) /= 2;
    }
  };
  for (const bool in_right : {false, true}) {
    Parts parts = scene;
    behind_filter(in_right ? parts.right : parts.left);
    ExpectBad(parts, Question::kBits, "behind a colour filter");
  }
  // Noise has no neighbours.
  Parts parts = scene;
  for (cv::Mat1b* image : {&parts.left, &parts.right}) {
    cv::RNG(1).fill(*image, cv::RNG::UNIFORM, 0, 250);
  }
  EXPECT_EQ(parts.Answer(Question::kBits).verdict, Verdict::kGood);
}

TEST(CheckInputs, MeasuresOneContrast) {
  for (const double contrast : {0.25, 0.7, 1.0, 1.5}) {
    Parts parts = SceneOf();
    parts.left = cv::Mat(parts.left * 0.6);
    parts.right = cv::Mat(parts.right * 0.6 * contrast);
    const Finding finding = parts.Answer(Question::kContrast);
    EXPECT_NEAR(finding.value, contrast, 0.03);
    EXPECT_EQ(finding.verdict, contrast == 1 ? Verdict::kGood : Verdict::kBad);
    EXPECT_EQ(parts.Answer(Question::kScale).verdict, Verdict::kGood) << "asked all the same";
  }
}

TEST(CheckInputs, AsksForANumberThatMayMeanNothing) {
  Parts parts = SceneOf();
  const cv::Rect hole(40, 30, 14, 12);
  parts.tof.depth_m(hole).setTo(32.767F);
  ExpectBad(parts, Question::kHits, "168 pixels of the range image have exactly 32.767 m");
  EXPECT_EQ(parts.Answer(Question::kHits).no_return_m, 32.767F);
  // Also among the depths of the scene; all else is asked of the others.
  std::vector<float> depths(parts.tof.depth_m.begin(), parts.tof.depth_m.end());
  std::ranges::nth_element(depths, depths.begin() + std::ssize(depths) / 4);
  const float code = depths[depths.size() / 4] + 0.0003F;
  for (int y = 0; y < parts.tof.depth_m.rows; ++y) {
    for (int x = y % 3; x < parts.tof.depth_m.cols; x += 3) parts.tof.depth_m(y, x) = code;
  }
  parts.tof.depth_m(hole).setTo(code);
  EXPECT_EQ(parts.Answer(Question::kHits).no_return_m, code) << parts.Answer(Question::kHits).text;
  EXPECT_EQ(parts.Answer(Question::kScale).verdict, Verdict::kGood);
  // A wall of one distance is where stereo sees it, too.
  parts = SceneOf("synthetic:640x480?tof=grid");
  double far = 0;
  cv::minMaxLoc(parts.tof.depth_m, nullptr, &far);
  parts.tof.depth_m.setTo(far, parts.tof.depth_m > 0.97 * far);
  EXPECT_EQ(parts.Answer(Question::kHits).verdict, Verdict::kGood);
  // Nor is it the cure where all ranges are in another unit.
  parts.tof.depth_m *= 0.256;
  EXPECT_EQ(parts.Answer(Question::kHits).verdict, Verdict::kGood);
  EXPECT_EQ(parts.Answer(Question::kScale).verdict, Verdict::kBad);
}

TEST(CheckInputs, AsksForAScaleThatNothingShows) {
  Parts parts = SceneOf();
  parts.rig.pair.baseline_m *= 1000;
  parts.tof = {};
  ExpectBad(parts, Question::kScale, "m apart");
  parts.rig.pair.baseline_m /= 1000 * parts.rig.pair.focal_px;  // P of ROS with −b
  EXPECT_THAT(parts.Answer(Question::kScale).text, HasSubstr("mm apart"));
}

TEST(CheckInputs, SeesACalibrationOfImagesOfAnotherSize) {
  for (const double times : {0.5, 1.2, 2.0}) {
    Parts parts = SceneOf();
    parts.tof = {};
    RectifiedPair& pair = parts.rig.pair;
    pair.focal_px *= times;
    pair.cx *= times;
    pair.cx_right *= times;
    pair.cy *= times;
    const Finding finding = parts.Answer(Question::kScale);
    EXPECT_EQ(finding.verdict, times == 1.2 ? Verdict::kCannotTell : Verdict::kBad) << times;
    EXPECT_EQ(finding.text.find("another size") != std::string::npos, times != 1.2) << times;
    pair.cy = 239;  // a crop may be anywhere
    EXPECT_EQ(parts.Answer(Question::kScale).verdict, Verdict::kCannotTell) << times;
  }
  // Of images four times as large, in which it is not in the middle.
  Parts quarter = SceneOf();
  quarter.tof = {};
  quarter.rig.pair.cx += 900;
  quarter.rig.pair.cx_right += 900;
  quarter.rig.pair.cy += 480;
  ExpectBad(quarter, Question::kScale, "another size");
  // Of a command line with --cx and without --cy.
  for (const double times : {0.5, 1.4, 2.0}) {
    Parts parts = SceneOf();
    parts.tof = {};
    parts.rig.pair.cx *= times;
    parts.rig.pair.cy = 239.5;
    EXPECT_EQ(parts.Answer(Question::kScale).verdict,
              times == 1.4 ? Verdict::kCannotTell : Verdict::kBad)
        << times;
  }
}

TEST(CheckInputs, SaysThatPrincipalPointsDoNotFit) {
  Parts parts = SceneOf();
  parts.rig.pair.cx_right -= 40;  // nearer surfaces have more than 40 px of disparity
  ExpectBad(parts, Question::kSides, "further right than ranges say");
  parts.tof = TofImage();
  ExpectBad(parts, Question::kSides, "principal points");
}

TEST(CheckInputs, TakesADevicesOwnErrorForGood) {
  for (const double error_m : {-0.03, 0.03}) {
    Parts parts = SceneOf();
    parts.tof.depth_m += error_m;
    EXPECT_THAT(BadText(parts.Check()), testing::IsEmpty());
    EXPECT_THAT(parts.Answer(Question::kScale).text, HasSubstr(error_m > 0 ? "(+" : "(-"));
  }
}

TEST(CheckInputs, SaysHowARangeImageIsTurned) {
  Parts parts = SceneOf();
  const cv::Mat1f upright = parts.tof.depth_m.clone();
  for (const auto& [axis, text] : {std::pair(0, "upside down"),
                                   std::pair(1, "mirrored left to right"), std::pair(-1, "180°")}) {
    cv::flip(upright, parts.tof.depth_m, axis);
    ExpectBad(parts, Question::kPlace, text);
  }
  // As a file that was turned: rows are columns, and it lies over the left image.
  cv::rotate(upright, parts.tof.depth_m, cv::ROTATE_90_CLOCKWISE);
  parts.rig.tof = TofOverLeft(parts.rig.pair, parts.tof.depth_m.size());
  EXPECT_THAT(parts.Answer(Question::kPlace).text, HasSubstr("turn it counter-clockwise"));
}

// A range sensor that is turned by 3 degrees to the right, and is taken for one that is not: what
// it sees belongs further right.
TEST(CheckInputs, SaysHowFarARangeSensorIsDisplaced) {
  for (const auto& [axis, text] :
       {std::pair<Eigen::Vector3d, const char*>(Eigen::Vector3d::UnitY(), "px further right in"),
        std::pair<Eigen::Vector3d, const char*>(-Eigen::Vector3d::UnitX(), "px further down in")}) {
    Parts parts = SceneOf();
    const Eigen::AngleAxisd off(-5 * M_PI / 180, axis);
    parts.rig.tof.left_from_tof_rotation = off * parts.rig.tof.left_from_tof_rotation;
    ExpectBad(parts, Question::kPlace, text);
  }
}

TEST(CheckInputs, SaysThatRangesAreNoise) {
  Parts parts = SceneOf();
  cv::RNG random(1);
  random.fill(parts.tof.depth_m, cv::RNG::UNIFORM, 1.0, 4.0);
  ExpectBad(parts, Question::kHits, "% of the ranges side by side differ by more than a tenth");
}

// A scanner that stands aside sees two surfaces in one direction of the camera.
TEST(CheckInputs, TakesNoPointsOfTwoSurfacesForNoise) {
  Parts parts = SceneOf("synthetic:640x480?tof=none");
  const Parts dense = SceneOf("synthetic:640x480?tof=grid");
  parts.tof.depth_m = cv::Mat1f(480, 640, 0.F);
  int count = 0;
  for (int v = 0; v < 480; v += 5) {
    for (int u = 0; u < 640; u += 10) {
      const float depth_m = dense.tof.depth_m(v / 10, u / 10);
      parts.tof.depth_m(v, u) = depth_m;
      if (++count % 50 == 0) parts.tof.depth_m(v, u + 1) = 1.5F * depth_m;
    }
  }
  parts.rig.tof = scenes::TofGridCamera(parts.rig.pair, 1);
  EXPECT_EQ(parts.Answer(Question::kHits).verdict, Verdict::kGood)
      << parts.Answer(Question::kHits).text;
}

TEST(CheckInputs, SaysThatRangesAreOfAnotherMoment) {
  Parts parts = SceneOf();
  parts.rig.tof.left_from_tof_translation_m.z() += 0.5;  // as if the rig had moved on meanwhile
  ExpectBad(parts, Question::kMoment, "further back");
}

// A road whose disparity grows from row to row, and a lidar of eight beams 60 rows apart: between
// two of them the points of one beam say nothing of the road.
TEST(CheckInputs, TakesALidarOfFewBeamsOnARoadForGood) {
  Parts parts = SceneOf();
  cv::RNG random(1);
  random.fill(parts.left, cv::RNG::UNIFORM, 0, 256);
  cv::GaussianBlur(parts.left, parts.left, {}, 1.2);
  cv::normalize(parts.left, parts.left, 0, 255, cv::NORM_MINMAX);
  const auto disparity = [](double v) { return 10 + 0.3 * v; };
  for (int v = 0; v < parts.left.rows; ++v) {
    const int d = cvRound(disparity(v));
    for (int u = 0; u < parts.left.cols; ++u) {
      parts.right(v, u) = parts.left(v, std::min(u + d, parts.left.cols - 1));
    }
  }
  const RectifiedPair& pair = parts.rig.pair;
  const TofProjector projector(parts.rig);
  for (int y = 0; y < parts.tof.depth_m.rows; ++y) {
    for (int x = 0; x < parts.tof.depth_m.cols; ++x) {
      const Eigen::Vector3d ray = projector.ray(x, y);
      const double v = pair.focal_px * ray.y() / ray.z() + pair.cy;
      const double depth_m = pair.focal_px * pair.baseline_m / disparity(v);
      parts.tof.depth_m(y, x) = y % 6 == 0 ? static_cast<float>(depth_m) : 0;
    }
  }
  EXPECT_EQ(BadText(parts.Check()), "");
}

TEST(CheckInputs, SaysThatRangesAreOfAnotherScene) {
  Parts parts = SceneOf();
  // The range image, rolled on by two fifths of its width: no turn puts that right.
  const cv::Mat1f whole = parts.tof.depth_m.clone();
  const int on = whole.cols * 2 / 5;
  whole.colRange(0, whole.cols - on).copyTo(parts.tof.depth_m.colRange(on, whole.cols));
  whole.colRange(whole.cols - on, whole.cols).copyTo(parts.tof.depth_m.colRange(0, on));
  const Finding finding = parts.Answer(Question::kMoment);
  EXPECT_EQ(finding.verdict, Verdict::kBad) << finding.text;
}

TEST(CheckInputs, DoesNotJudgeWithoutEvidence) {
  Parts parts = SceneOf();
  parts.left.setTo(90);
  parts.right.setTo(90);
  for (const Finding& finding : parts.Check()) {
    if (finding.question == Question::kBits || finding.question == Question::kHits) continue;
    EXPECT_EQ(finding.verdict, Verdict::kCannotTell) << NameOf(finding.question);
    EXPECT_FALSE(finding.text.empty());
  }
}

TEST(CheckInputs, WithoutRangesAnswersWhatImagesTell) {
  Parts parts = SceneOf();
  parts.tof = {};
  EXPECT_EQ(parts.Answer(Question::kRows).verdict, Verdict::kGood);
  for (const Question question :
       {Question::kHits, Question::kPlace, Question::kScale, Question::kMoment}) {
    EXPECT_EQ(parts.Answer(question).verdict, Verdict::kCannotTell);
  }
}

TEST(CheckInputs, SaysThatARangeImageIsEmptyOrHitsNothing) {
  Parts parts = SceneOf();
  Parts aside = parts;
  parts.tof.depth_m = cv::Mat1f(parts.tof.depth_m.size(), 0.0F);
  EXPECT_THAT(parts.Answer(Question::kHits).text, HasSubstr("has a return"));
  EXPECT_EQ(parts.Answer(Question::kHits).verdict, Verdict::kBad);
  aside.rig.tof.left_from_tof_translation_m.x() = 1000;
  EXPECT_EQ(aside.Answer(Question::kHits).verdict, Verdict::kBad);
  EXPECT_THAT(aside.Answer(Question::kHits).text, HasSubstr("where does the range sensor stand"));
}

// Whole metres, read as mm: too near for the right camera, and too coarse to tell a scale.
TEST(CheckInputs, SaysThatRangesAreTooNearForBothPictures) {
  Parts parts = SceneOf("synthetic:640x480?tof=sr4000");
  for (float& depth_m : parts.tof.depth_m) depth_m = 0.001F * std::round(depth_m);
  parts.rig.tof = TofOverLeft(parts.rig.pair, parts.tof.depth_m.size());
  const Finding finding = parts.Answer(Question::kHits);
  EXPECT_EQ(finding.verdict, Verdict::kBad) << finding.text;
  EXPECT_THAT(finding.text, HasSubstr("lie outside the right one"));
  EXPECT_THAT(finding.text, HasSubstr("in which unit are ranges"));
}

// A near wall of which both cameras see a tenth.
TEST(CheckInputs, TakesRangesForGoodOfWhichSomeAreInOnePictureOnly) {
  Parts parts = SceneOf();
  const RectifiedPair& pair = parts.rig.pair;
  const double d = 0.9 * pair.width + pair.cx_right - pair.cx;
  parts.tof.depth_m.setTo(pair.focal_px * pair.baseline_m / d);
  parts.rig.tof = TofOverLeft(pair, parts.tof.depth_m.size());
  EXPECT_EQ(parts.Answer(Question::kHits).verdict, Verdict::kGood);
}

TEST(CheckInputs, SaysThatImagesAreWhite) {
  Parts parts = SceneOf();
  EXPECT_EQ(parts.Answer(Question::kBits).verdict, Verdict::kGood);
  parts.left = cv::Mat(parts.left * 4);
  ExpectBad(parts, Question::kBits, "% of the pixels are white");
}

TEST(CheckInputs, SaysThatImagesUseFewBits) {
  Parts parts = SceneOf();
  parts.left /= 64;
  parts.right /= 64;
  ExpectBad(parts, Question::kBits, "10 or 12 bits in 16");
}

TEST(CheckInputs, SaysWhatSizeIsAllowed) {
  Parts parts = SceneOf();
  parts.right = parts.right(cv::Rect(0, 0, 600, 480)).clone();
  EXPECT_THAT(parts.Answer(Question::kScene).text, HasSubstr("640x480"));
  EXPECT_EQ(parts.Answer(Question::kScene).verdict, Verdict::kCannotTell);
}

TEST(CheckInputs, WorksOnImagesOfAnySize) {
  for (const cv::Size size :
       {cv::Size(1, 1), cv::Size(17, 3), cv::Size(40, 30), cv::Size(3, 400)}) {
    Parts parts{
        .left = cv::Mat1b(size), .right = {}, .tof = {cv::Mat1f(size, 1.0F), {}}, .rig = {}};
    cv::RNG random(7);
    random.fill(parts.left, cv::RNG::UNIFORM, 0, 256);
    parts.right = parts.left.clone();
    parts.rig.pair = CentredPair(size.width, size.height, 50);
    parts.rig.tof = TofOverLeft(parts.rig.pair, size);
    EXPECT_EQ(parts.Check().size(), static_cast<size_t>(kQuestionCount));
  }
}

}  // namespace
}  // namespace sprout::inputs
