#include <gmock/gmock.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <opencv2/imgproc.hpp>
#include <string>

#include "common/core/input_files.h"
#include "common/picture/write_image.h"
#include "tests/services/pipeline/files_fixture.h"

namespace sprout {
namespace {

namespace fs = std::filesystem;

using testing::HasSubstr;

TEST_F(Files, ThatCannotBeUsedAreRefusedBeforeAnythingIsComputed) {
  const std::string nothing = folder_ / "nothing";
  const std::string empty = folder_ / "empty";
  fs::create_directories(empty);
  const std::string loop = folder_ / "loop";
  fs::create_symlink(loop, loop);
  Write("two/1.png", scene_.left);
  Write("two/2.png", scene_.left);
  Write("two/2.bmp", scene_.left);
  fs::copy(folder_ / "two", folder_ / "again");
  const std::string blocked = folder_ / "left.png/out";
  const std::string middlebury =
      "cam0=[90 0 9; 0 90 9; 0 0 1]\ncam1=[90 0 9; 0 90 9; 0 0 1]\nbaseline=9\n";
  const auto calib_of = [&](const std::string& text) {
    std::ofstream(folder_ / "calib.txt") << text << "\n";
    return std::string(folder_ / "calib.txt");
  };
  const struct {
    std::function<void(FilesOptions&)> change;
    std::string text;
  } table[] = {
      {[&](auto& o) { o.left = nothing; }, "LEFT " + nothing + ": not there; allowed: "},
      {[&](auto& o) { o.tof = "/dev/null"; },
       "--tof /dev/null: neither a file nor a folder; allowed: "},
      {[&](auto& o) { o.left = loop; },
       "LEFT " + loop + ": not there (Too many levels of symbolic links); allowed: "},
      {[&](auto& o) { o.right = empty; }, "RIGHT " + empty + ": holds no image"},
      {[&](auto& o) { o.tof = nothing + "*"; }, "--tof " + nothing + "*: no file is called so"},
      {[&](auto& o) { o.left = folder_ / "two/*.png"; },
       "LEFT and RIGHT: neither times nor names say which of 2 and 1 files belong together"},
      {[&](auto& o) { o.left = o.right = folder_ / "two"; },
       "LEFT and RIGHT: both are " + std::string(folder_ / "two") + "; allowed: one of each"},
      {[&](auto& o) {
         o.left = folder_ / "two";
         o.right = folder_ / "again";
       },
       "LEFT: images of one name"},
      {[&](auto& o) { o.right = folder_ / "./left.png"; }, "LEFT and RIGHT: both are "},
      {[&](auto& o) { o.rig = {}; }, "no calibration; allowed: --rig FILE, or of a rectified pair"},
      {[&](auto& o) { o.pixels.tof_unit = "1/0"; }, "--tof-unit 1/0: allowed: mm, cm, m, 1/N"},
      {[&](auto& o) { o.pixels.bits = 7; }, "--bits 7: allowed: 8 to 16, or 0"},
      {[&](auto& o) { o.rig.rig_file = nothing; }, nothing},
      {[&](auto& o) { o.rig = {.calib_file = nothing}; },
       "calibration " + nothing + ": cannot be read (No such file"},
      {[&](auto& o) { o.rig = {.calib_file = calib_of("fx 90")}; },
       "neither Middlebury's (cam0=) nor KITTI's (P2:, P_rect_02:); allowed: one of these, "
       "--focal-px and --baseline-m, or of OpenCV, ROS and Kalibr --rig with what sprout-calibrate "
       "import makes of it"},
      {[&](auto& o) { o.rig = {.calib_file = calib_of("cam0=[9 0 4]")}; },
       "cam0=[9 0 4]: allowed: "},
      {[&](auto& o) { o.rig = {.calib_file = calib_of(middlebury + "width=wide")}; },
       "width=wide: allowed: a finite number"},
      {[&](auto& o) { o.rig = {.calib_file = calib_of("P2: 90 0")}; }, "P2: 90 0: allowed: "},
      {[&](auto& o) { o.rig = {.calib_file = calib_of("P0: 90 0\nP1: 1")}; },
       "P0: 90 0: allowed: "},
      {[&](auto& o) { o.out = blocked; }, "--out " + blocked + ": cannot be written ("},
      {[&](auto& o) { o.out = "/proc"; }, "--out /proc/camera.json: cannot be written ("},
  };
  for (const auto& [change, text] : table) {
    FilesOptions options = options_;
    change(options);
    EXPECT_THAT(RefusalOf(options), HasSubstr(text));
  }
}

TEST_F(Files, ThatAreReadAreNotReplaced) {
  const InputFileGuard guard;
  options_.tof = Write("out/depth.png", cv::Mat1w(30, 40, uint16_t{2000}));
  EXPECT_THAT(RefusalOf(options_), HasSubstr("depth.png is an input of this run"));
  EXPECT_EQ(cv::imread(options_.tof, cv::IMREAD_UNCHANGED).at<uint16_t>(0, 0), 2000);
  // The second pair's, by the first one's results, through a link.
  const std::string read = Write("out/1/overview.png", scene_.left);
  for (const char* name : {"l/1.png", "l/2.png", "r/1.png"}) Write(name, scene_.left);
  fs::create_symlink(read, folder_ / "r/2.png");
  options_.left = folder_ / "l";
  options_.right = folder_ / "r";
  options_.tof.clear();
  EXPECT_THAT(RefusalOf(options_), HasSubstr("overview.png is an input of this run"));
}

TEST_F(Files, WhoseNamesAreStepsUpAreRefused) {
  for (const char* name : {"up/...png", "up/..png"}) {
    const std::string path = folder_ / name;
    fs::create_directories(folder_ / "up");
    ASSERT_TRUE(WritePng(path, scene_.left));
    options_.left = folder_ / "up/.*png";
    EXPECT_THAT(RefusalOf(options_), HasSubstr("its results would go to")) << name;
    fs::remove(path);
  }
}

TEST_F(Files, WhoseContentCannotBeUsedGetOneLine) {
  std::ofstream(folder_ / "text.png") << "no image\n";
  std::ofstream(folder_ / "short.pfm") << "Pf\n40 30\n-1\nabc";
  const struct {
    std::function<void(FilesOptions&)> change;
    std::string text;
  } table[] = {
      {[&](auto& o) { o.left = folder_ / "text.png"; }, "text.png: "},
      {[&](auto& o) { o.tof = folder_ / "left.png"; },
       "left.png: of OpenCV's type CV_8UC3; allowed: one channel of 16 bits (mm), or of floating "
       "point (m; PFM, TIFF)\n"},
      {[&](auto& o) { o.tof = folder_ / "short.pfm"; }, "short.pfm: ends early"},
      {[&](auto& o) { o.rig.focal_px = std::nan(""); }, "focal_px"},
      {[&](auto& o) { o.rig.baseline_m = 0; }, "baseline_m"},
  };
  for (const auto& [change, text] : table) {
    FilesOptions options = options_;
    change(options);
    const MainOutcome outcome = RunToEnd(options);
    EXPECT_EQ(outcome.exit_code, 1) << text;
    EXPECT_THAT(outcome.err, HasSubstr(text));
    EXPECT_FALSE(fs::exists(folder_ / "out")) << "an empty folder is left";
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  }
}

// One focal length is given.
TEST_F(Files, OfAnotherSizeThanTheFirstAreLeftOut) {
  cv::Mat half_left, half_right;
  cv::resize(scene_.left, half_left, {}, 0.5, 0.5);
  cv::resize(scene_.right, half_right, {}, 0.5, 0.5);
  Write("l/1.png", scene_.left);
  Write("l/2.png", half_left);
  Write("r/1.png", scene_.right);
  Write("r/2.png", half_right);
  options_.left = folder_ / "l";
  options_.right = folder_ / "r";
  const MainOutcome outcome = RunToEnd(options_);
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.err, HasSubstr("2.png: the left image is 80x60: allowed is the size of the "
                                     "first, 160x120, as all have one --focal-px"));
  EXPECT_FALSE(fs::exists(folder_ / "out" / "2"));
}

TEST_F(Files, InWhichNothingIsFoundAreWrong) {
  const cv::Mat1b grey(pair_.height, pair_.width, uint8_t{100});
  FilesOptions flat = options_;
  flat.left = Write("flat.png", grey);
  flat.right = Write("flat_right.png", grey);
  const MainOutcome nothing = RunToEnd(flat);
  EXPECT_EQ(nothing.exit_code, 1);
  EXPECT_THAT(nothing.err, HasSubstr("; refine: no ToF point has a return"));
  EXPECT_THAT(nothing.err, HasSubstr("; grow: no seeds to grow from\n"));
  EXPECT_EQ(std::count(nothing.err.begin(), nothing.err.end(), '\n'), 1) << nothing.err;
  EXPECT_THAT(nothing.out, HasSubstr("0.0 % of the pixels have a depth"));
  EXPECT_THAT(nothing.out, testing::Not(HasSubstr("grow: ")));
  EXPECT_TRUE(fs::exists(folder_ / "out" / "depth.pfm"));

  // The maps are good, and all of the depths are left out.
  const MainOutcome near = RunToEnd(options_, {}, {"default", "depth { max_m: 0.01 }"});
  EXPECT_EQ(near.exit_code, 1);
  EXPECT_THAT(near.err, testing::EndsWith("left.png: 0 of 19200 pixels have a depth\n"));
}

TEST_F(Files, NearerThanStereoIsSearchedAreWrong) {
  const std::vector<std::string> few = {"default", "refine { stereo_max_disparity_px: 5 }"};
  const MainOutcome near = RunToEnd(options_, {}, few);
  EXPECT_EQ(near.exit_code, 1);
  EXPECT_THAT(
      near.err,
      HasSubstr(" px, and stereo is searched up to 5 px: near things need refine { stereo_max_"));
  options_.tof = folder_ / "tof.png";
  EXPECT_THAT(RunToEnd(options_, {}, few).err, testing::Not(HasSubstr("stereo is searched")));
}

TEST_F(Files, OfAVideoThatIsCutAreNotWrong) {
  const cv::Rect part(20, 10, 120, 100);
  Write("l/1.png", scene_.left);
  Write("r/1.png", scene_.right);
  Write("l/2.png", scene_.left(part));
  Write("r/2.png", scene_.right(part));
  options_.left = folder_ / "l";
  options_.right = folder_ / "r";
  const MainOutcome ended = RunToEnd(options_, {}, {"default", "temporal { in_pipeline: true }"});
  EXPECT_EQ(ended.exit_code, 0);
  EXPECT_THAT(ended.err, testing::IsEmpty());
  EXPECT_THAT(ended.out, HasSubstr("; temporal: earlier frames forgotten: another rig"));
}

}  // namespace
}  // namespace sprout
