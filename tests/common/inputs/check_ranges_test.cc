#include <gmock/gmock.h>

#include <cmath>

#include "common/inputs/check_inputs.h"
#include "tests/common/inputs/parts.h"

// The unit and the lens of ranges.
namespace sprout::inputs {
namespace {

using testing::HasSubstr;

Parts Scaled(double factor) {
  Parts parts = SceneOf();
  parts.tof.depth_m *= factor;
  return parts;
}

TEST(CheckInputs, NamesTheUnitOfRanges) {
  struct Case {
    double factor;
    const char* text;
    const char* flag;
  };
  for (const auto& [factor, text, flag] :
       {Case{256.0 / 1000, "3.906", "--tof-unit 1/256"},
        Case{5000.0 / 1000, "1/5000 m", "--tof-unit 1/5000"},
        Case{1000, "in mm, and read as m", "--tof-unit mm"},
        Case{10, "1/10 mm", "--tof-unit 1/10000"}, Case{1.3, "focal length and baseline", ""}}) {
    const Parts parts = Scaled(factor);
    const Finding finding = parts.Answer(Question::kScale);
    EXPECT_EQ(finding.verdict, Verdict::kBad) << factor;
    EXPECT_NEAR(finding.value / factor, 1, 0.01);
    EXPECT_THAT(finding.text, HasSubstr(text));
    EXPECT_THAT(finding.text, testing::Not(HasSubstr("--"))) << "a graph has no such flags";
    EXPECT_EQ(finding.flag, flag);
    EXPECT_NE(parts.Answer(Question::kPlace).verdict, Verdict::kBad);
  }
}

// The second fault is told with the first one; right ranges are not blamed for a pair.
TEST(CheckInputs, NamesTheUnitAndTheTurnOfRangesBesideAPairThatDoesNotFit) {
  const auto lower = [](Parts parts) {
    cv::warpAffine(parts.right, parts.right, cv::Matx23d(1, 0, 0, 0, 1, 4), parts.right.size());
    return parts;
  };
  ExpectBad(lower(Scaled(0.256)), Question::kRows, "px off those");
  ExpectBad(lower(Scaled(0.256)), Question::kScale, "1/256 m");
  Parts mirrored = SceneOf();
  cv::flip(mirrored.tof.depth_m, mirrored.tof.depth_m, 1);
  ExpectBad(lower(mirrored), Question::kPlace, "mirrored left to right");
  Parts inverse = SceneOf();
  for (float& depth : inverse.tof.depth_m) depth = 1 / depth;
  ExpectBad(lower(inverse), Question::kScale, "inverse depths");
  Parts half = SceneOf();
  half.tof.depth_m.rowRange(0, half.tof.depth_m.rows / 2) *= 0.6;
  ExpectBad(lower(half), Question::kMoment, "disagree");
  const auto turned = [](Parts parts) {
    cv::warpAffine(parts.right, parts.right, cv::Matx23d(1, 0.02, 0, -0.02, 1, 0),
                   parts.right.size());
    return parts;
  };
  for (const Question question : {Question::kPlace, Question::kScale, Question::kMoment}) {
    EXPECT_EQ(lower(SceneOf()).Answer(question).verdict, Verdict::kGood);
    EXPECT_EQ(turned(SceneOf()).Answer(question).verdict, Verdict::kCannotTell);
    EXPECT_EQ(turned(Scaled(1.3)).Answer(question).verdict, Verdict::kCannotTell);
  }
}

TEST(CheckInputs, NamesDisparitiesThatAreGivenAsRanges) {
  for (const char* source : {"synthetic:640x480?tof=grid", "synthetic:640x480?tof=sr4000"}) {
    for (const double factor : {1.0, 35.0}) {
      Parts parts = SceneOf(source);
      for (float& depth : parts.tof.depth_m) depth = static_cast<float>(factor / depth);
      ExpectBad(parts, Question::kScale, "are they disparities, or inverse depths?");
      EXPECT_NE(parts.Answer(Question::kMoment).verdict, Verdict::kBad);
    }
  }
}

TEST(CheckInputs, NamesDistancesAlongTheRays) {
  Parts parts = SceneOf();
  TofCamera& tof = parts.rig.tof;
  // The same disparities in a wider view.
  parts.rig.pair.focal_px /= 2;
  parts.rig.pair.baseline_m *= 2;
  tof.fx /= 2;
  tof.fy /= 2;
  for (int y = 0; y < tof.height; ++y) {
    for (int x = 0; x < tof.width; ++x) {
      const double right = (x - tof.cx) / tof.fx, down = (y - tof.cy) / tof.fy;
      parts.tof.depth_m(y, x) *= static_cast<float>(std::hypot(right, down, 1));
    }
  }
  ExpectBad(parts, Question::kScale, "too long towards the sides");
  EXPECT_NE(parts.Answer(Question::kMoment).verdict, Verdict::kBad);
}

TEST(CheckInputs, NamesRangesWhoseBytesAreInTheOtherOrder) {
  Parts parts = SceneOf();
  for (float& depth : parts.tof.depth_m) {
    const int mm = cvRound(1000 * depth);
    depth = static_cast<float>((mm & 255) << 8 | mm >> 8) / 1000;
  }
  ExpectBad(parts, Question::kScale, "bytes of the ranges are in the other order");
}

TEST(CheckInputs, NamesRangesWithTheirConfidenceInTheUpperBits) {
  Parts parts = SceneOf();
  for (int y = 0; y < parts.tof.depth_m.rows; ++y) {
    for (float& depth : parts.tof.depth_m.row(y)) depth += 8.192F * static_cast<float>(y / 8 % 8);
  }
  ExpectBad(parts, Question::kScale, "confidence in the upper three");
}

TEST(CheckInputs, NamesRangesWithoutDecimals) {
  // The scene with everything five times as far.
  Parts parts = SceneOf();
  parts.rig.pair.baseline_m *= 5;
  parts.tof.depth_m *= 5;
  EXPECT_EQ(parts.Answer(Question::kHits).verdict, Verdict::kGood);
  for (float& depth : parts.tof.depth_m) depth = std::round(depth);
  ExpectBad(parts, Question::kHits, "whole metres");
}

TEST(CheckInputs, SaysOfWholeMetresThatAreReadAsMillimetresOnlyThatTheyAreTooNear) {
  Parts parts = SceneOf();
  for (float& depth : parts.tof.depth_m) depth = std::min(2.F, std::round(depth)) / 1000;
  EXPECT_NE(parts.Answer(Question::kSides).verdict, Verdict::kBad);
  ExpectBad(parts, Question::kHits, "in which unit are ranges");
}

TEST(CheckInputs, NamesTheUnitOfRangesBeyondAllSensors) {
  Parts parts = Scaled(1e5);
  EXPECT_THAT(parts.Answer(Question::kHits).text, HasSubstr("beyond 10000 m"));
}

TEST(CheckInputs, SaysThatARangeImageHasAnotherFieldOfView) {
  for (const double times : {0.8, 1.0, 1.25}) {
    Parts parts = SceneOf("synthetic:640x480?tof=grid");
    parts.rig.tof.fx *= times;
    parts.rig.tof.fy *= times;
    const Finding finding = parts.Answer(Question::kScale);
    EXPECT_EQ(finding.verdict, times == 1 ? Verdict::kGood : Verdict::kBad) << times;
    EXPECT_EQ(finding.text.find("times the field of view") != std::string::npos, times != 1)
        << finding.text;
  }
}

// A range image of 4:3 that is taken for what a left one of 16:9 shows.
TEST(CheckInputs, SaysThatARangeImageHasOtherProportions) {
  Parts parts = SceneOf("synthetic:640x480?tof=grid");
  parts.rig.tof.fx *= 0.75;
  ExpectBad(parts, Question::kScale, "(down) times the field of view");
  // Every third row alone is another thing.
  parts = SceneOf("synthetic:640x480?tof=grid");
  TofCamera& tof = parts.rig.tof;
  cv::Mat1f rows(tof.height / 3, tof.width);
  for (int y = 0; y < rows.rows; ++y) parts.tof.depth_m.row(3 * y).copyTo(rows.row(y));
  parts.tof = {.depth_m = rows, .amplitude = {}};
  tof.height = rows.rows;
  tof.fy /= 3;
  tof.cy /= 3;
  EXPECT_EQ(parts.Answer(Question::kScale).verdict, Verdict::kGood);
}

TEST(CheckInputs, SeesARangeLensOfImagesOfAnotherSize) {
  const Parts scene = SceneOf("synthetic:640x480?tof=sr4000");
  for (const double times : {0.25, 0.5, 2.0, 4.0}) {
    Parts parts = scene;
    for (double* number :
         {&parts.rig.tof.fx, &parts.rig.tof.fy, &parts.rig.tof.cx, &parts.rig.tof.cy}) {
      *number *= times;
    }
    ExpectBad(parts, Question::kScale, "the range sensor's principal point (");
    EXPECT_NE(parts.Answer(Question::kPlace).verdict, Verdict::kBad);
    EXPECT_NE(parts.Answer(Question::kMoment).verdict, Verdict::kBad);
  }
  // The upper left part of a larger image.
  Parts cropped = scene;
  const cv::Rect part(0, 0, scene.rig.tof.width * 2 / 3, scene.rig.tof.height * 2 / 3);
  cropped.tof.depth_m = scene.tof.depth_m(part).clone();
  cropped.tof.amplitude = scene.tof.amplitude(part).clone();
  cropped.rig.tof.width = part.width;
  cropped.rig.tof.height = part.height;
  EXPECT_NE(cropped.Answer(Question::kScale).verdict, Verdict::kBad)
      << cropped.Answer(Question::kScale).text;
}

}  // namespace
}  // namespace sprout::inputs
