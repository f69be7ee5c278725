// What `sprout-pipeline files` makes of the images and calibrations that people have.

#include <gmock/gmock.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>

#include "common/core/read_text.h"
#include "common/scenes/pfm.h"
#include "tests/services/pipeline/files_of_box.h"

namespace sprout {
namespace {

namespace fs = std::filesystem;

using testing::HasSubstr;
using testing::IsEmpty;

using FilesInput = FilesOfBox;

TEST_F(FilesInput, AreJoinedByTheTimesInTheirNames) {
  // The box moves 4 px a frame; left has lost frame 2, right frame 1, the ToF camera frame 3.
  for (int i = 0; i < 5; ++i) {
    const std::string name = std::to_string(1403636579763555584 + 50'000'000LL * i) + ".png";
    const Scene scene(4 * (i - 2));
    if (i != 2) Write("l/" + name, scene.left);
    if (i != 1) Write("r/" + name, scene.right);
  }
  options_.left = Path("l");
  options_.right = Path("r");
  EXPECT_EQ(Run(), 1);
  EXPECT_THAT(err_, HasSubstr("1 of 4 images of LEFT have no right image and are left out: " +
                              Path("l/1403636579813555584.png")));
  EXPECT_THAT(err_, HasSubstr("1 of 4 images of RIGHT have no left image and are left out: " +
                              Path("r/1403636579863555584.png")));
  for (const int i : {0, 3, 4}) {
    const std::string name = std::to_string(1403636579763555584 + 50'000'000LL * i);
    EXPECT_GT(Right(Depth("out/" + name), 4 * (i - 2)), 90) << i;
  }
  EXPECT_FALSE(fs::exists(Path("out/1403636579813555584")));
}

TEST_F(FilesInput, OfNumbersComeInTheirOrder) {
  const Scene scene;
  for (const char* number : {"0", "2", "10"}) {
    Write("l/" + std::string(number) + ".png", scene.left);
    Write("r/" + std::string(number) + ".png", scene.right);
    std::ofstream(Path("l/._" + std::string(number) + ".png")) << "Mac OS X";
  }
  options_.left = Path("l");
  options_.right = Path("r");
  EXPECT_EQ(Run(), 0) << err_;
  EXPECT_THAT(err_, IsEmpty());
  const size_t two = out_.find("out/2:");
  EXPECT_NE(two, std::string::npos);
  EXPECT_LT(two, out_.find("out/10:"));
}

TEST_F(FilesInput, ThatCountFromAnotherNumberAreAskedAbout) {
  const Scene scene;
  for (const int number : {8, 9, 10}) {
    Write("l/" + std::to_string(number) + ".png", scene.left);
    Write("r/" + std::to_string(number + 1) + ".png", scene.right);
  }
  options_.left = Path("l");
  options_.right = Path("r");
  EXPECT_EQ(Run(), 1);
  EXPECT_THAT(err_, HasSubstr("LEFT and RIGHT are as many, and one begins earlier"));
  fs::remove(Path("l/8.png"));  // left lost one: nothing is asked
  EXPECT_EQ(Run(), 1);
  EXPECT_THAT(err_, testing::Not(HasSubstr("as many")));
}

TEST_F(FilesInput, OfTwoVideosAreJoinedByTime) {
  const auto write = [&](const char* name, double fps, bool left) {
    cv::VideoWriter video(Path(name), cv::CAP_FFMPEG, cv::VideoWriter::fourcc('F', 'F', 'V', '1'),
                          fps, kSize);
    ASSERT_TRUE(video.isOpened());
    for (int i = 0; i < cvRound(fps / 2); ++i) {
      const Scene scene(cvRound(40 * (i / fps - 0.25)));
      cv::Mat bgr;
      cv::cvtColor(left ? scene.left : scene.right, bgr, cv::COLOR_GRAY2BGR);
      video.write(bgr);
    }
  };
  write("l.avi", 4, true);
  write("r.avi", 20, false);
  options_.left = Path("l.avi");
  options_.right = Path("r.avi");
  EXPECT_EQ(Run(), 0) << err_;
  EXPECT_THAT(err_, HasSubstr("videos of 4 and 20 pictures a second: joined by time"));
  EXPECT_GT(Right(Depth("out/000000"), -10), 90);
  EXPECT_GT(Right(Depth("out/000001"), 0), 90);
  EXPECT_FALSE(fs::exists(Path("out/000002")));

  options_.right = Path("right.png");
  EXPECT_EQ(Run(), 2);
  EXPECT_THAT(err_, HasSubstr("one is a video, the other is not"));
}

TEST_F(FilesInput, Of10And12BitsAreAsThoseOf8) {
  Run();
  const double eight = Right(Depth());
  EXPECT_GT(eight, 90);
  const Scene scene;
  for (const int bits : {10, 12, 14}) {
    cv::Mat left;
    cv::Mat right;
    // As in a dim room: a quarter of the range is used.
    scene.left.convertTo(left, CV_16U, std::pow(2, bits - 8));
    scene.right.convertTo(right, CV_16U, std::pow(2, bits - 8));
    options_.left = Write("left16.png", left);
    options_.right = Write("right16.png", right);
    EXPECT_EQ(Run(), 0);
    EXPECT_NEAR(Right(Depth()), eight, 0.01) << bits;
    EXPECT_THAT(err_, HasSubstr("left16.png: pixels of 16 bits use 0 to ")) << bits;
  }
  options_.pixels.bits = 16;
  Run();
  EXPECT_THAT(err_, IsEmpty());
  EXPECT_EQ(cv::imread(Path("out/left.png"), cv::IMREAD_GRAYSCALE).at<uint8_t>(9, 9),
            scene.left(9, 9) >> 2);
}

TEST_F(FilesInput, OfConvergedPairsHaveNegativeDisparities) {
  for (const int move : {6, 14, -6}) {
    for (const bool with_tof : {false, true}) {
      Show(Scene(0, move));
      options_.rig.cx = 47.5;
      options_.rig.cx_right = 47.5 + move;
      options_.tof = with_tof ? Write("tof.png", RangePicture(1000)) : "";
      EXPECT_EQ(Run(), 0) << err_;
      EXPECT_GT(Right(Depth()), 90) << move << with_tof << out_;
      const cv::Mat1f px = scenes::ReadPfm(Path("out/disparity.pfm"));
      EXPECT_NEAR(px(15, 30), kFarPx - move, 0.3);
      EXPECT_EQ(out_.find("negative") != std::string::npos, move > kFarPx) << out_;
    }
  }
}

TEST_F(FilesInput, HaveTheRowOfTheirPrincipalPoints) {
  options_.rig.cy = 20;
  EXPECT_EQ(Run(), 0);
  const std::string camera = ReadText(Path("out/camera.json"), 1000).value();
  EXPECT_THAT(camera, HasSubstr("\"focal_px\": 90,\n  \"cx\": 47.5,\n  \"cy\": 20,\n"));
  EXPECT_THAT(camera, HasSubstr("\"baseline_m\": 0.1\n}"));
  // The first vertex is pixel (0, 0) or one near it in the first row: y = -20/90 z.
  std::ifstream ply(Path("out/cloud.ply"), std::ios::binary);
  std::string line;
  while (std::getline(ply, line) && line != "end_header") {
  }
  float xyz[3];
  ply.read(reinterpret_cast<char*>(xyz), sizeof xyz);
  EXPECT_NEAR(xyz[1] / xyz[2], -20 / kFocalPx, 1e-4);
}

TEST_F(FilesInput, HaveTheCalibrationOfMiddleburyOrKitti) {
  options_.rig = {};
  options_.rig.calib_file = Path("calib.txt");
  std::ofstream(options_.rig.calib_file) << "cam0=[90 0 47.5; 0 90 20; 0 0 1]\n"
                                            "cam1=[90 0 47.5; 0 90 20; 0 0 1]\n"
                                            "baseline=100\n";
  EXPECT_EQ(Run(), 0) << err_;
  EXPECT_GT(Right(Depth()), 90);
  EXPECT_THAT(ReadText(Path("out/camera.json"), 1000).value(), HasSubstr("\"cy\": 20,"));
  std::ofstream(options_.rig.calib_file) << "P0: 90 0 47.5 0 0 90 25 0 0 0 1 0\n"
                                            "P1: 90 0 47.5 -9 0 90 25 0 0 0 1 0\n"
                                            "P2: 90 0 47.5 1 0 90 26 0 0 0 1 0\n"
                                            "P3: 90 0 47.5 -9 0 90 26 0 0 0 1 0\n";
  EXPECT_EQ(Run(), 0) << err_;
  EXPECT_GT(Right(Depth()), 90);
  EXPECT_THAT(ReadText(Path("out/camera.json"), 1000).value(), HasSubstr("\"cy\": 25,"));
}

}  // namespace
}  // namespace sprout
