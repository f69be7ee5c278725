// What `sprout-pipeline files` makes of the files that people have.

#include <gmock/gmock.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>

#include "common/core/read_text.h"
#include "common/picture/write_image.h"
#include "common/scenes/pfm.h"
#include "services/pipeline/files/files.h"
#include "tests/common/app/run_main.h"
#include "tests/common/picture/temporary_directory.h"

namespace sprout {
namespace {

namespace fs = std::filesystem;

using testing::HasSubstr;
using testing::IsEmpty;

const cv::Size kSize{96, 72};
constexpr double kFocalPx = 90;
constexpr double kBaselineM = 0.1;
constexpr int kFarPx = 4;    // disparity of the background: 2.25 m
constexpr int kNearPx = 10;  // of a box in the middle: 0.90 m
const cv::Rect kBox(36, 24, 26, 26);

// Noise that is the same for equal places, so that views of it match.
uint8_t Texture(int x, int y) {
  uint32_t hash =
      static_cast<uint32_t>(x + 1000) * 73856093U ^ static_cast<uint32_t>(y) * 19349663U;
  hash = (hash ^ (hash >> 13)) * 1274126177U;
  return static_cast<uint8_t>(20 + (hash >> 16) % 200);
}

// Depth, m, at a pixel of the left image.
double DepthAt(int u, int v, int shift = 0) {
  const bool near = kBox.contains({u - shift, v});
  return kFocalPx * kBaselineM / (near ? kNearPx : kFarPx);
}

// A box before a wall. The right image is moved by whole pixels: cx' = cx + move.
struct Scene {
  explicit Scene(int box_shift = 0, int move = 0) : left(kSize), right(kSize) {
    for (int v = 0; v < kSize.height; ++v) {
      for (int u = 0; u < kSize.width; ++u) {
        left(v, u) = At(u, v, box_shift, 0);
        right(v, u) = At(u - move, v, box_shift, 1);
      }
    }
  }

  // The grey value that the left (0) or the right (1) camera sees.
  static uint8_t At(int u, int v, int box_shift, int right) {
    const int in_box = u + right * kNearPx;
    if (kBox.contains({in_box - box_shift, v})) return Texture(in_box - box_shift + 500, v);
    return Texture(u + right * kFarPx, v);
  }

  cv::Mat1b left, right;
};

cv::Mat1w RangePicture(double counts_per_metre) {
  cv::Mat1w tof(kSize);
  for (int v = 0; v < kSize.height; ++v) {
    for (int u = 0; u < kSize.width; ++u) {
      tof(v, u) = static_cast<uint16_t>(std::lround(DepthAt(u, v) * counts_per_metre));
    }
  }
  return tof;
}

class FilesInput : public testing::Test {
 protected:
  FilesInput() {
    options_.out = Path("out");
    options_.rig.focal_px = kFocalPx;
    options_.rig.baseline_m = kBaselineM;
    Show(Scene());
  }

  std::string Path(const std::string& name) const { return folder_ / name.c_str(); }

  std::string Write(const std::string& name, const cv::Mat& image) const {
    fs::create_directories(fs::path(Path(name)).parent_path());
    EXPECT_TRUE(cv::imwrite(Path(name), image)) << name;
    return Path(name);
  }

  void Show(const Scene& scene) {
    options_.left = Write("left.png", scene.left);
    options_.right = Write("right.png", scene.right);
  }

  int Run() {
    std::string refusal;
    const MainOutcome outcome = Captured([&] {
      try {
        return RunFiles(options_, LoadConfig({"default"}), {});
      } catch (const ConfigError& e) {
        refusal = e.what();
        return 2;
      }
    });
    out_ = outcome.out;
    err_ = refusal + outcome.err;
    return outcome.exit_code;
  }

  cv::Mat1f Depth(const std::string& folder = "out") const {
    return scenes::ReadPfm(Path(folder + "/depth.pfm"));
  }

  // Percentage of the pixels whose depth is right within 3 %, away from the borders.
  double Right(const cv::Mat1f& depth_m, int box_shift = 0) const {
    constexpr int kBorder = 12;
    int right = 0;
    int all = 0;
    for (int v = kBorder; v < depth_m.rows - kBorder; ++v) {
      for (int u = 2 * kBorder; u < depth_m.cols - 2 * kBorder; ++u) {
        ++all;
        right += std::abs(depth_m(v, u) / DepthAt(u, v, box_shift) - 1) < 0.03 ? 1 : 0;
      }
    }
    return 100.0 * right / all;
  }

  TemporaryDirectory folder_;
  FilesOptions options_;
  std::string out_;
  std::string err_;
};

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

TEST_F(FilesInput, OfARangeCameraThatLacksSomeAreComputedWithout) {
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

TEST_F(FilesInput, OfRangesAreInTheUnitThatIsGiven) {
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

TEST_F(FilesInput, OfANumberThatMeansNothingAreComputedWithoutIt) {
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

TEST_F(FilesInput, OfRangesThatAreWrongAreComputedWithout) {
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

TEST_F(FilesInput, OfRangesHaveNoReturnWhere65535Is) {
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

TEST_F(FilesInput, OfARangeCameraBesideTheLeftOneAreWhereItsRigFileSays) {
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
  EXPECT_THAT(err_, HasSubstr("the ToF image is 20x20: allowed is the calibrated size 48x36"));
  std::ofstream(options_.rig.tof_rig_file) << "calibration { }\n";
  EXPECT_EQ(Run(), 2);
  EXPECT_THAT(err_, HasSubstr("tof.textproto: no ToF camera; allowed: a file with calibration"));
}

}  // namespace
}  // namespace sprout
