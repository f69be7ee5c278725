#include <gmock/gmock.h>
#include <sys/stat.h>

#include <cmath>
#include <opencv2/core.hpp>

#include "common/scenes/middlebury_calibration.h"
#include "tests/common/scenes/scene_folder.h"

namespace sprout::scenes {
namespace {

using testing::AllOf;
using testing::HasSubstr;

TEST(MiddleburyErrors, ListsEveryNameOfAMissingImage) {
  const SceneFolder empty;
  EXPECT_THAT(OpenError(empty.Config()), AllOf(HasSubstr("view1.png, view1.jpg, view1.ppm"),
                                               HasSubstr("im0.png, im0.jpg, im0.ppm")));
  for (const std::string name : {"view5", "disp1"}) {
    const SceneFolder folder(cv::Size(40, 30));
    folder.Remove(name + ".png");
    EXPECT_THAT(OpenError(folder.Config()),
                AllOf(HasSubstr(folder.File("").substr(0, folder.File("").size() - 1)),
                      HasSubstr(name + " is missing"),
                      HasSubstr(name + ".png, " + name + ".jpg, " + name + ".ppm")));
  }
}

TEST(MiddleburyErrors, NamesWhatIsMissingIn2014) {
  for (const auto& [file, message] : {std::pair{"im1.png", "im1.png, im1.jpg, im1.ppm"},
                                      {"disp0.pfm", "allowed: disp0.pfm"},
                                      {"calib.txt", "calib.txt: cannot be read"}}) {
    const SceneFolder folder(SceneFolder::k2014);
    folder.Remove(file);
    EXPECT_THAT(OpenError(folder.Config()), HasSubstr(message));
  }
}

TEST(MiddleburyErrors, NamesBothSizesWhenTheyDiffer) {
  for (const std::string name : {"view5.png", "disp1.png", "disp5.png"}) {
    const SceneFolder folder(cv::Size(40, 30));
    folder.WriteImage(name, cv::Mat1b(31, 40, uchar{9}));
    EXPECT_THAT(OpenError(folder.Config()),
                AllOf(HasSubstr(folder.File(name)), HasSubstr("40x31"), HasSubstr("40x30")));
  }
  for (const std::string name : {"disp0.pfm", "disp1.pfm"}) {
    const SceneFolder folder(SceneFolder::k2014);
    folder.WritePfm(name, cv::Mat1f(20, 29, 1.0f), "-1");
    EXPECT_THAT(OpenError(folder.Config()),
                AllOf(HasSubstr(folder.File(name)), HasSubstr("29x20"), HasSubstr("30x20")));
  }
}

TEST(MiddleburyErrors, NamesAnImageThatCannotBeDecoded) {
  for (const std::string& text : {std::string(), std::string("no image")}) {
    for (const std::string name : {"view1.png", "view5.png", "disp1.png"}) {
      const SceneFolder folder(cv::Size(40, 30));
      folder.WriteText(name, text);
      EXPECT_THAT(OpenError(folder.Config()),
                  AllOf(HasSubstr(folder.File(name)), HasSubstr("cannot be decoded")));
    }
  }
}

TEST(MiddleburyErrors, RefusesColouredAnd16BitGroundTruth) {
  for (const cv::Mat& codes :
       {cv::Mat(SomePicture({40, 30})), cv::Mat(cv::Mat1w(30, 40, uint16_t{9}))}) {
    const SceneFolder folder(cv::Size(40, 30));
    folder.WriteImage("disp1.png", codes);
    EXPECT_THAT(OpenError(folder.Config()),
                AllOf(HasSubstr(folder.File("disp1.png")), HasSubstr("allowed: 8-bit grey")));
  }
}

TEST(MiddleburyErrors, RefusesASceneWithoutAKnownDisparity) {
  const SceneFolder codes(cv::Size(40, 30));
  codes.WriteImage("disp1.png", cv::Mat1b(30, 40, uchar{0}));
  EXPECT_THAT(OpenError(codes.Config()),
              AllOf(HasSubstr(codes.File("disp1.png")), HasSubstr("no disparity is known")));

  const SceneFolder pfm(SceneFolder::k2014);
  pfm.WritePfm("disp0.pfm", cv::Mat1f(20, 30, INFINITY), "-1");
  EXPECT_THAT(OpenError(pfm.Config()),
              AllOf(HasSubstr(pfm.File("disp0.pfm")), HasSubstr("no disparity is known")));
}

TEST(MiddleburyErrors, RefusesADminThatIsNoNumber) {
  for (const std::string text : {"", "a", "200 px", "nan", "inf", "1e999", "2,5"}) {
    const SceneFolder folder(cv::Size(40, 30));
    folder.WriteText("dmin.txt", text);
    EXPECT_THAT(OpenError(folder.Config()),
                AllOf(HasSubstr(folder.File("dmin.txt")), HasSubstr("allowed: one finite number")))
        << text;
  }
}

// One line of a good calib.txt replaced, or dropped when the new one is empty.
std::string CalibWith(const std::string& key, const std::string& value) {
  std::string text;
  for (const auto& [name, good] :
       {std::pair<std::string, std::string>{"cam0", "[100 0 14; 0 100 9; 0 0 1]"},
        {"cam1", "[100 0 17; 0 100 9; 0 0 1]"},
        {"baseline", "193"},
        {"doffs", "3"},
        {"width", "30"},
        {"height", "20"}}) {
    const std::string& chosen = name == key ? value : good;
    if (!chosen.empty()) text += name + "=" + chosen + "\n";
  }
  return text;
}

struct CalibCase {
  std::string key;
  std::string value;
  std::string message;
};

void PrintTo(const CalibCase& broken, std::ostream* out) {
  *out << broken.key << " = '" << broken.value << "'";
}

class MiddleburyCalib : public testing::TestWithParam<CalibCase> {};

TEST_P(MiddleburyCalib, IsRefusedWithKeyAndReason) {
  const CalibCase& c = GetParam();
  const SceneFolder folder(SceneFolder::k2014);
  folder.WriteText("calib.txt", CalibWith(c.key, c.value));
  EXPECT_THAT(OpenError(folder.Config()),
              AllOf(HasSubstr(folder.File("calib.txt")), HasSubstr(c.message)));
}

INSTANTIATE_TEST_SUITE_P(
    Broken, MiddleburyCalib,
    testing::Values(CalibCase{"cam0", "", "cam0 is missing"},
                    CalibCase{"cam1", "", "cam1 is missing"},
                    CalibCase{"baseline", "", "baseline is missing"},
                    CalibCase{"cam0", "[100 0 14; 0 100 9; 0 0]", "allowed: [f 0 cx;"},
                    CalibCase{"cam0", "100 0 14 0 100 9 0 0 1", "allowed: [f 0 cx;"},
                    CalibCase{"cam0", "[x 0 14; 0 100 9; 0 0 1]", "cam0=[x 0 14"},
                    CalibCase{"cam0", "[nan 0 14; 0 nan 9; 0 0 1]", "with finite numbers"},
                    CalibCase{"cam1", "[100 0 inf; 0 100 9; 0 0 1]", "with finite numbers"},
                    CalibCase{"cam0", "[0 0 14; 0 0 9; 0 0 1]", "a focal length above 0"},
                    CalibCase{"cam0", "[-100 0 14; 0 -100 9; 0 0 1]", "a focal length above 0"},
                    CalibCase{"cam1", "[101 0 17; 0 101 9; 0 0 1]", "one focal length"},
                    CalibCase{"cam1", "[100 0 17; 0 100 8; 0 0 1]", "cam0's row"},
                    CalibCase{"baseline", "0", "allowed: a number above 0, mm"},
                    CalibCase{"baseline", "-193", "allowed: a number above 0, mm"},
                    CalibCase{"baseline", "0.193", "which is mm; is it in m?"},
                    CalibCase{"baseline", "nan", "allowed: a finite number"},
                    CalibCase{"baseline", "193\nbaseline=1", "baseline is given more than once"},
                    CalibCase{"cam0", "[1 0 0; 0 1 0; 0 0 1]\ncam0=[100 0 14; 0 100 9; 0 0 1]",
                              "cam0 is given more than once"},
                    CalibCase{"width", "30\nwidth=30", "width is given more than once"},
                    CalibCase{"doffs", "500", "doffs=500: allowed: 3 ± 1 px"},
                    CalibCase{"doffs", "-3", "doffs=-3: allowed: 3 ± 1 px"},
                    CalibCase{"baseline", "wide", "baseline=wide"},
                    CalibCase{"width", "2964", "allowed: 30, as the images have"},
                    CalibCase{"height", "2000", "allowed: 20, as the images have"}));

// Keys that nothing reads may say what they like.
TEST(MiddleburyErrors, AcceptsARoundedDoffsAndRepeatedKeysOfOthers) {
  for (const std::string doffs : {"2.2", "3.9", "3\nndisp=20\nndisp=30"}) {
    const SceneFolder folder(SceneFolder::k2014);
    folder.WriteText("calib.txt", CalibWith("doffs", doffs));
    EXPECT_EQ(folder.Open()->rig().pair.cx_right, 17) << doffs;
  }
}

TEST(MiddleburyErrors, AcceptsACalibrationWithoutSizeOrDoffs) {
  for (const std::string key : {"width", "height", "doffs", "none"}) {
    const SceneFolder folder(SceneFolder::k2014);
    folder.WriteText("calib.txt", CalibWith(key, ""));
    EXPECT_EQ(folder.Open()->rig().pair.cx_right, 17);
  }
}

// As a file of --calib, too.
TEST(MiddleburyErrors, AcceptsBlanksAroundTheEqualsSign) {
  const SceneFolder folder;
  folder.WriteText("calib.txt",
                   "cam0 = [90 0 9; 0 90 9; 0 0 1]\ncam1 = [90 0 12; 0 90 9; 0 0 1]\n"
                   "baseline = 90\n");
  EXPECT_EQ(OpenCalibFile(folder.File("calib.txt"))({40, 30}, true).cx_right, 12);
}

TEST(MiddleburyErrors, RefusesABrokenPfm) {
  const std::string samples(4 * 30 * 20, '\0');
  for (const auto& [text, message] : {std::pair<std::string, std::string>{"", "header"},
                                      {"PF\n30 20\n-1\n" + samples, "header"},
                                      {"Pf\n30\n", "header"},
                                      {"Pf\n0 20\n-1\n", "size 0x20"},
                                      {"Pf\n-30 20\n-1\n", "size -30x20"},
                                      {"Pf\n30 99999999\n-1\n", "size 30x99999999"},
                                      {"Pf\n30 20\n0\n" + samples, "scale is 0"},
                                      {"Pf\n16384 16384\n-1\n" + samples, "ends early"},
                                      {"Pf\n30 20\n-1\n" + samples + "\n", "1 bytes behind"},
                                      {std::string(1 << 20, 'P'), "header"},
                                      {"Pf\n30 20\n-1\n" + samples.substr(1), "ends early"}}) {
    const SceneFolder folder(SceneFolder::k2014);
    folder.WriteText("disp0.pfm", text);
    EXPECT_THAT(OpenError(folder.Config()),
                AllOf(HasSubstr(folder.File("disp0.pfm")), HasSubstr(message)));
  }
}

TEST(MiddleburyErrors, ReadsAPfmWithLineEndsOfWindows) {
  const SceneFolder folder(SceneFolder::k2014);
  const cv::Mat1f before = folder.Open()->Get(0).truth.left;
  std::string text = FileText(folder.File("disp0.pfm"));
  for (size_t line = 0, at = 0; line < 3; ++line, at += 2) {
    at = text.find('\n', at);
    text.replace(at, 1, "\r\n");
  }
  folder.WriteText("disp0.pfm", text);
  const cv::Mat1f after = folder.Open()->Get(0).truth.left;
  EXPECT_EQ(after(5, 7), before(5, 7));
  EXPECT_EQ(after(2, 3), 7.5F);
}

TEST(MiddleburyErrors, RefusesCalibrationsThatAreNoFile) {
  for (const auto& [target, reason] : {std::pair{"dmin.txt", "Too many levels of symbolic links"},
                                       std::pair{"/dev/zero", "no regular file"},
                                       std::pair{"nowhere", "No such file or directory"}}) {
    const SceneFolder folder(cv::Size(40, 30));
    std::filesystem::create_symlink(target, folder.File("dmin.txt"));
    EXPECT_THAT(OpenError(folder.Config()),
                HasSubstr(std::string("dmin.txt: cannot be read (") + reason + "); allowed: "));
  }
  const SceneFolder fifo(cv::Size(40, 30));
  ASSERT_EQ(mkfifo(fifo.File("dmin.txt").c_str(), 0600), 0);
  EXPECT_THAT(OpenError(fifo.Config()),
              HasSubstr("dmin.txt: cannot be read (no regular file); allowed: "));

  const SceneFolder scene2014(SceneFolder::k2014);
  scene2014.Remove("calib.txt");
  std::filesystem::create_symlink("calib.txt", scene2014.File("calib.txt"));
  EXPECT_THAT(
      OpenError(scene2014.Config()),
      HasSubstr("calib.txt: cannot be read (Too many levels of symbolic links); allowed: "));
}

TEST(MiddleburyErrors, RefusesImagesWiderThanAnyMessageMayBe) {
  const SceneFolder folder(cv::Size(16385, 3));
  EXPECT_THAT(OpenError(folder.Config()),
              HasSubstr("view1.png: 16385x3 px; allowed: 1 to 16384 px a side"));
  folder.Write2005({40, 30});
  folder.WriteText("view5.png", "P6\n30000 40000\n255\nabc");
  EXPECT_THAT(OpenError(folder.Config()),
              HasSubstr("view5.png: 30000x40000 px; allowed: 1 to 16384 px a side"));
}

TEST(MiddleburyErrors, RefusesATofGridWiderThanTheImage) {
  const SceneFolder folder(cv::Size(40, 30));
  CaptureConfig config = folder.Config();
  config.set_tof_grid_px(31);
  EXPECT_THAT(OpenError(config), AllOf(HasSubstr("40x30"), HasSubstr("allowed: 1 to 30")));
}

}  // namespace
}  // namespace sprout::scenes
