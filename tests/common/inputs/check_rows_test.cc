#include <fmt/core.h>
#include <gmock/gmock.h>

#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "tests/common/inputs/parts.h"

namespace sprout::inputs {
namespace {

TEST(CheckRows, MeasuresHowFarRowsAreOff) {
  for (const double rows : {-14.0, -3.0, 2.0, 8.5}) {
    const Finding finding = Moved({1, 0, 0, 0, 1, rows}).Answer(Question::kRows);
    EXPECT_EQ(finding.verdict, Verdict::kBad) << rows;
    EXPECT_NEAR(finding.value, rows, 0.3);
    EXPECT_LT(finding.sigma, 0.1);
  }
  const Finding finding = Moved({1, 0, 0, 0, 1, 0.5}).Answer(Question::kRows);
  EXPECT_EQ(finding.verdict, Verdict::kGood);
  EXPECT_NEAR(finding.value, 0.5, 0.15);
}

TEST(CheckRows, SeesARoll) {
  const double angle = 0.7 * CV_PI / 180;
  ExpectBad(Moved({std::cos(angle), -std::sin(angle),
                   320 * (1 - std::cos(angle)) + 240 * std::sin(angle), std::sin(angle),
                   std::cos(angle), 240 * (1 - std::cos(angle)) - 320 * std::sin(angle)}),
            Question::kRows, "roll +0.7");
}

// Rows are off by 0.9 px only, columns by more.
TEST(CheckRows, SeesWhatAnotherScaleDoesToColumns) {
  for (const double scale : {1.006, 0.994}) {
    const Parts parts = Moved({scale, 0, 320 * (1 - scale), 0, scale, 240 * (1 - scale)});
    ExpectBad(parts, Question::kRows, scale > 1 ? "things +0.6" : "things -0.6");
    const Finding finding = parts.Answer(Question::kRows);
    EXPECT_NEAR(finding.value, 1.4, 0.15);
    EXPECT_LT(finding.sigma, 0.1);
  }
}

// Neither a shift, a roll nor another focal length: in the middle the rows agree.
TEST(CheckRows, SeesARightCameraThatIsTurnedToTheLeft) {
  Parts parts = SceneOf();
  const cv::Matx33d camera(640, 0, 320, 0, 640, 240, 0, 0, 1);
  cv::Matx33d turn;
  cv::Rodrigues(cv::Vec3d(0, 1.5 * CV_PI / 180, 0), turn);
  cv::Mat1b turned;
  cv::warpPerspective(parts.right, turned, camera * turn * camera.inv(), parts.right.size(),
                      cv::INTER_CUBIC, cv::BORDER_REFLECT);
  parts.right = turned;
  ExpectBad(parts, Question::kRows, "are bent");
}

TEST(CheckRows, SeesADistortionThatWasNotRemoved) {
  const cv::Matx33d camera(640, 0, 320, 0, 640, 240, 0, 0, 1);
  for (const double k1 : {0.04, -0.04}) {
    Parts parts = SceneOf();
    cv::Mat1b distorted;
    cv::undistort(parts.right, distorted, camera, cv::Vec4d(k1, 0, 0, 0));
    parts.right = distorted;
    ExpectBad(parts, Question::kRows, "the distortion of its lenses");
  }
}

TEST(CheckRows, SaysByHowMuchColumnsAreAsideOfRanges) {
  for (const int columns : {-12, 12}) {
    Parts parts = SceneOf();
    const double right = parts.rig.pair.cx_right;
    parts.rig.pair.cx_right += columns;
    ExpectBad(parts, Question::kSides,
              fmt::format("further {} than ranges say", columns > 0 ? "left" : "right"));
    ExpectBad(parts, Question::kSides,
              fmt::format("(cx_right {:.1f}, not {:.1f})", right, right + columns));
  }
}

}  // namespace
}  // namespace sprout::inputs
