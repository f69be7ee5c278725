// What `sprout-pipeline files` makes of the ranges that people have.

#include <gmock/gmock.h>

#include <cmath>
#include <fstream>
#include <opencv2/core.hpp>
#include <utility>

#include "common/picture/write_image.h"
#include "tests/services/pipeline/files_of_box.h"

namespace sprout {
namespace {

using testing::HasSubstr;

using FilesRanges = FilesOfBox;

TEST_F(FilesRanges, MayLackForSomePairs) {
  const Scene scene;
  for (const char* number : {"0", "1"}) {
    Write("l/" + std::string(number) + ".png", scene.left);
    Write("r/" + std::string(number) + ".png", scene.right);
  }
  Write("t/1.png", RangePicture(1000));
  Write("t/2.png", RangePicture(1000));
  options_.left = Path("l");
  options_.right = Path("r");
  options_.tof = Path("t");
  EXPECT_EQ(Run(), 0);
  EXPECT_THAT(err_,
              HasSubstr("have no ToF image, their pairs are computed without: " + Path("l/0.png")));
  EXPECT_THAT(err_, HasSubstr("1 of 2 images of --tof have no left image and are not used"));
  EXPECT_GT(Right(Depth("out/0")), 90);
  EXPECT_GT(Right(Depth("out/1")), 90);
}

TEST_F(FilesRanges, AreInTheUnitThatIsGiven) {
  for (const auto& [unit, counts] : {std::pair{"mm", 1000.0},
                                     {"1/256", 256.0},
                                     {"1/5000", 5000.0},
                                     {"0.002", 500.0},
                                     {"", 1000.0}}) {
    options_.tof = Write("tof.png", RangePicture(counts));
    options_.pixels.tof_unit = unit;
    EXPECT_EQ(Run(), 0);
    EXPECT_GT(Right(Depth()), 95) << unit;
  }
  cv::Mat1f mm;
  RangePicture(1000).convertTo(mm, CV_32F);
  options_.tof = Path("tof.PFM");
  ASSERT_TRUE(WritePfm(options_.tof, mm));
  options_.pixels.tof_unit = "m";
  EXPECT_EQ(Run(), 1);
  EXPECT_THAT(err_, HasSubstr("and read as mm? --tof-unit mm"));
  options_.pixels.tof_unit = "mm";
  EXPECT_EQ(Run(), 0) << err_;
  EXPECT_GT(Right(Depth()), 95);
  options_.pixels.tof_unit = "";
  for (const int type : {CV_32F, CV_64F}) {  // NumPy's own is 64 bits
    cv::Mat metres;
    mm.convertTo(metres, type, 0.001);
    options_.tof = Write("tof.tiff", metres);
    EXPECT_EQ(Run(), 0) << err_;
    EXPECT_GT(Right(Depth()), 95);
  }
}

TEST_F(FilesRanges, OfANumberThatMeansNothingAreLeftOut) {
  cv::Mat1w depth;
  RangePicture(1000).convertTo(depth, CV_16U);
  for (int y = 0; y < depth.rows; ++y) {
    for (int x = y % 3; x < depth.cols; x += 3) depth(y, x) = 65533;
  }
  options_.tof = Write("tof.png", depth);
  EXPECT_EQ(Run(), 1);
  EXPECT_THAT(err_, HasSubstr("; ranges of exactly 65.533 m are left out"));
  EXPECT_GT(Right(Depth()), 95);
}

TEST_F(FilesRanges, ThatAreWrongAreNotUsed) {
  EXPECT_EQ(Run(), 0);
  const cv::Mat1f without = Depth();
  cv::Mat1w noise(RangePicture(1000).size());
  cv::RNG(1).fill(noise, cv::RNG::UNIFORM, 1000, 4000);
  options_.tof = Write("tof.png", noise);
  EXPECT_EQ(Run(), 1);
  EXPECT_THAT(err_, HasSubstr("is it noise"));
  EXPECT_THAT(err_, HasSubstr("no range is believed"));
  EXPECT_EQ(cv::countNonZero(Depth() != without), cv::countNonZero(without != without));
}

TEST_F(FilesRanges, HaveNoReturnWhere65535Is) {
  cv::Mat1w tof = RangePicture(1000);
  tof(cv::Rect(0, 0, 48, 72)).setTo(65535);
  options_.tof = Write("tof.png", tof);
  EXPECT_EQ(Run(), 0);
  const cv::Mat1f depth = Depth();
  tof.setTo(0, tof == 65535);
  options_.tof = Write("tof.png", tof);
  EXPECT_EQ(Run(), 0);
  EXPECT_EQ(cv::countNonZero(depth != Depth()), cv::countNonZero(depth != depth));
  EXPECT_GT(Right(depth), 90);
}

// As programs save grey with alpha, and OpenCV reads it.
TEST_F(FilesRanges, OfGreyInColourAreThoseOfGrey) {
  const cv::Mat1w grey = RangePicture(1000);
  cv::Mat1w masked = grey.clone();
  masked(cv::Rect(0, 0, 48, 72)).setTo(0);
  cv::Mat1w alpha(grey.size(), 65535);
  alpha.setTo(0, masked == 0);
  const auto depth_of = [&](const std::vector<cv::Mat>& planes) {
    cv::Mat image;
    cv::merge(planes, image);
    options_.tof = Write("tof.png", image);
    EXPECT_EQ(Run(), 0) << err_;
    return Depth();
  };
  const cv::Mat1f depth = depth_of({masked});
  for (const cv::Mat1f& other :
       {depth_of({grey, grey, grey, alpha}), depth_of({masked, masked, masked})}) {
    EXPECT_EQ(cv::countNonZero(depth != other), cv::countNonZero(depth != depth));
  }
  for (const std::vector<cv::Mat>& planes :
       {std::vector<cv::Mat>{grey, grey, masked}, {grey, grey, grey, alpha / 2}}) {
    cv::Mat image;
    cv::merge(planes, image);
    options_.tof = Write("tof.png", image);
    EXPECT_EQ(Run(), 1);
    EXPECT_THAT(err_, HasSubstr("allowed: one channel of 16 bits"));
  }
}

TEST_F(FilesRanges, OfACameraBesideTheLeftOneAreWhereItsRigFileSays) {
  // Half the resolution, 0.05 m to the right, its own principal point.
  constexpr double kTofFocalPx = 40;
  cv::Mat1w tof(36, 48, uint16_t{0});
  for (int v = 0; v < tof.rows; ++v) {
    for (int u = 0; u < tof.cols; ++u) {
      for (const double depth : {0.9, 2.25}) {  // the nearer surface that this ray meets
        const double x = (u - 22) / kTofFocalPx * depth + 0.05;
        const double y = (v - 18) / kTofFocalPx * depth;
        const cv::Point at(cvRound(kFocalPx * x / depth + 47.5),
                           cvRound(kFocalPx * y / depth + 35.5));
        if (std::abs(DepthAt(at.x, at.y) - depth) > 0.01) continue;
        tof(v, u) = static_cast<uint16_t>(std::lround(1000 * depth));
        break;
      }
    }
  }
  options_.tof = Write("tof.png", tof);
  options_.rig.tof_rig_file = Path("tof.textproto");
  std::ofstream(options_.rig.tof_rig_file)
      << "calibration {\n  tof { width: 48 height: 36 fx: 40 fy: 40 cx: 22 cy: 18 }\n"
         "  left_from_tof { rotation: [1, 0, 0, 0] translation_m: [0.05, 0, 0] }\n}\n";
  EXPECT_EQ(Run(), 0) << err_;
  EXPECT_GT(Right(Depth()), 90);
  // A line per pair has the number of seeds: nearly all points are used.
  options_.tof = Write("small.png", cv::Mat(tof(cv::Rect(0, 0, 20, 20)).clone()));
  EXPECT_EQ(Run(), 1);
  EXPECT_THAT(err_, HasSubstr("ToF image of 20x20: allowed is the calibrated size 48x36"));
  std::ofstream(options_.rig.tof_rig_file) << "calibration { }\n";
  EXPECT_EQ(Run(), 2);
  EXPECT_THAT(err_, HasSubstr("tof.textproto: no ToF camera; allowed: a file with calibration"));
}

}  // namespace
}  // namespace sprout
