// Lenses of other programs, fitted by Brown's model.
#include <fmt/core.h>
#include <gmock/gmock.h>

#include <opencv2/calib3d.hpp>
#include <string>
#include <vector>

#include "common/config/required.h"
#include "services/tools/calibrate/import/foreign_rig.h"
#include "tests/common/testing/thrown.h"

namespace sprout::calibrate {
namespace {

using testing::HasSubstr;

// Checks that a model and the fitted one of Brown project points to the same places.
void ExpectSamePlaces(const ForeignCamera& camera, const Lens& lens) {
  cv::Matx33d k = cv::Matx33d::eye();
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) k(i, j) = camera.k(i, j);
  }
  for (const double x : {-0.5, 0.0, 0.4}) {
    for (const double y : {-0.3, 0.2}) {
      std::vector<cv::Point2d> theirs;
      if (camera.is_fisheye) {
        cv::fisheye::distortPoints(std::vector{cv::Point2d(x, y)}, theirs, k, camera.distortion);
      } else {
        cv::projectPoints(std::vector{cv::Point3d(x, y, 1)}, cv::Vec3d(), cv::Vec3d(), k,
                          camera.distortion, theirs);
      }
      std::vector<cv::Point2d> ours;
      cv::projectPoints(std::vector{cv::Point3d(x, y, 1)}, cv::Vec3d(), cv::Vec3d(),
                        cv::Matx33d(lens.fx, 0, lens.cx, 0, lens.fy, lens.cy, 0, 0, 1),
                        std::vector(lens.distortion.begin(), lens.distortion.end()), ours);
      EXPECT_LT(cv::norm(theirs[0] - ours[0]), kWorstFitPx) << x << ", " << y;
    }
  }
}

TEST(ImportLens, RefusesWhatNoModelOfOpencvHas) {
  ForeignCamera camera{.name = "cam0", .size = {640, 480}, .distortion = {}};
  camera.k << 800, 0, 320, 0, 800, 240, 0, 0, 1;
  for (const size_t count : {0, 4, 5, 8, 12, 14}) {
    camera.distortion.assign(count, 1e-5);
    EXPECT_EQ(WhyNot(ToLens(camera)), "") << count;
  }
  for (const size_t count : {1, 6, 9, 15}) {
    camera.distortion.assign(count, 1e-5);
    EXPECT_EQ(WhyNot(ToLens(camera)),
              fmt::format("cam0: {} distortion coefficients; allowed: 4, 5, 8, 12 or 14", count));
  }
  camera.is_fisheye = true;
  for (const size_t count : {0, 5}) {
    camera.distortion.assign(count, 1e-5);
    EXPECT_THAT(WhyNot(ToLens(camera)), HasSubstr("allowed: 4 of the fisheye model"));
  }
  camera.distortion.assign(4, 0.0);  // which is no pinhole
  EXPECT_EQ(WhyNot(ToLens(camera)), "");
  camera.k(0, 1) = 0.5;
  EXPECT_EQ(WhyNot(ToLens(camera)), "cam0: its camera matrix has a skew of 0.5 px; allowed: 0");
  camera.k << 500, 0, 0, 0, 500, 0, 320, 240, 1;
  EXPECT_THAT(WhyNot(ToLens(camera)), HasSubstr("is it transposed, as Matlab's"));
}

TEST(ImportLens, OtherModelsAreFittedWhereBrownsIsAsGood) {
  ForeignCamera camera{.name = "cam0", .size = {640, 480}, .distortion = {}};
  camera.k << 500, 0, 320, 0, 500, 240, 0, 0, 1;
  camera.distortion = {0.3, -0.1, 1e-4, 2e-4, 0.01, 0.5, -0.1, 0.02};  // rational
  const LensFit rational = Required(ToLens(camera));
  EXPECT_GT(rational.worst_px, 0);
  ExpectSamePlaces(camera, rational.lens);
  camera.distortion = {-0.01, 0.02, -0.01, 0.001};
  camera.is_fisheye = true;
  camera.k(0, 0) = camera.k(1, 1) = 800;
  const LensFit fisheye = Required(ToLens(camera));
  ExpectSamePlaces(camera, fisheye.lens);
  // 130 degrees are beyond it.
  camera.k(0, 0) = camera.k(1, 1) = 290;
  const std::string error = WhyNot(ToLens(camera));
  EXPECT_THAT(error, HasSubstr("cam0: its fisheye distortion is up to "));
  EXPECT_THAT(error, HasSubstr("allowed are 0.1"));
}

}  // namespace
}  // namespace sprout::calibrate
