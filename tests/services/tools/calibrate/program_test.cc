#include "services/tools/calibrate/program.h"

#include <gmock/gmock.h>
#include <wordexp.h>

#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>

#include "common/bus/channels.h"
#include "common/messages/codec.h"
#include "common/rig/rig_file.h"
#include "services/tools/calibrate/image_folder.h"
#include "services/tools/calibrate/watch.h"
#include "tests/common/app/run_main.h"
#include "tests/common/logfile/sample_log.h"
#include "tests/common/testing/thrown.h"
#include "tests/services/tools/calibrate/board_scene.h"

namespace sprout::calibrate {
namespace {

using ::testing::EndsWith;
using ::testing::HasSubstr;

MainOutcome RunCalibrate(std::vector<std::string> words) {
  words.insert(words.begin(), "sprout-calibrate");
  return RunMain(words, CalibrateMain);
}

class CalibrateProgram : public testing::Test {
 protected:
  std::string File(const char* name) const { return folder_ / name; }

  static void Append(const RigImages& images, int64_t seq, std::vector<Event>& events) {
    const FrameId id{.utime = 1'700'000'000'000'000 + 1'000'000 * seq, .seq = seq, .rig_id = ""};
    const auto add = [&](Part part, const PartValue& value) {
      events.push_back({.utime = id.utime,
                        .channel = "RAW_" + std::string(ChannelOf(part)),
                        .data = EncodePart(id, part, value)});
    };
    add(Part::kLeft, images.left);
    add(Part::kRight, images.right);
    add(Part::kTof, images.tof);
  }

  // A log of a board shown to a rig.
  std::string WriteLog(const char* name, int views) const {
    std::vector<Event> events;
    const std::vector<Pose> poses = BoardPoses(board_, views);
    for (uint32_t i = 0; i < poses.size(); ++i) Append(scene_.Render(poses[i], i), i, events);
    WriteBytes(folder_ / name, MakeLog(events));
    return File(name);
  }

  // Exit code, nothing on stdout, one line on stderr that holds `reason`.
  void ExpectRefused(const std::vector<std::string>& arguments, int exit_code,
                     const std::string& reason) const {
    sprout::ExpectRefused(RunCalibrate(arguments), exit_code, "sprout-calibrate", reason);
    EXPECT_FALSE(std::filesystem::exists(folder_ / "out.textproto"));
  }

  const Board board_{BoardSize{}};
  const RawRig rig_ = SceneRig({640, 480});
  const BoardScene scene_{board_, rig_};
  const TemporaryDirectory folder_;
};

TEST_F(CalibrateProgram, WritesABoard) {
  const MainOutcome outcome =
      RunCalibrate({"board", "--squares", "11x8", "--square-mm", "30", "--out", File("board.svg")});

  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("a board of 330 x 240 mm on a page of 360 x 285 mm; "));
  EXPECT_THAT(FileText(folder_ / "board.svg"), HasSubstr("viewBox=\"0 0 1020.472441 "));
}

TEST_F(CalibrateProgram, PrintsTheSizesThatItsReadmeSays) {
  const std::string readme =
      FileText(std::string(SPROUT_SOURCE_DIR) + "/services/tools/calibrate/README.md");
  const MainOutcome outcome = RunCalibrate({"board", "--out", File("board.svg")});
  EXPECT_THAT(outcome.out, HasSubstr("a board of 540 x 360 mm on a page of 570 x 405 mm"));
  EXPECT_THAT(readme, HasSubstr("540 × 360 mm, on a page of 570 × 405 mm"));
}

TEST_F(CalibrateProgram, MakesARigFileAndAReportOfALog) {
  RigDescription devices;
  devices.mutable_left()->set_serial("42");
  ASSERT_TRUE(SaveRigFile(folder_ / "devices.textproto", devices));

  const MainOutcome outcome =
      RunCalibrate({"estimate", WriteLog("raw.lcm", 10), "--rig", File("devices.textproto"),
                    "--out", File("rig.textproto"), "--report", File("report.html")});

  // Ten views are few: a warning says so, and the result does not replace a good one.
  EXPECT_EQ(outcome.exit_code, 1) << outcome.err;
  EXPECT_EQ(outcome.err, "");
  EXPECT_THAT(outcome.out, HasSubstr("10 images: 10 views used"));
  EXPECT_THAT(outcome.out, HasSubstr("calibration: not good enough"));
  EXPECT_THAT(outcome.out, HasSubstr("the left camera sees the board in 10 views only"));
  EXPECT_THAT(outcome.out, HasSubstr("not written to " + File("rig.textproto") + ", but to " +
                                     File("rig.not_good.textproto") + "\n"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "rig.textproto"));
  const RigDescription rig = LoadRigFile(folder_ / "rig.not_good.textproto");
  EXPECT_EQ(rig.left().serial(), "42");
  const RawRig found = CalibrationOf(rig).value();
  EXPECT_NEAR(found.left.fx / rig_.left.fx, 1, 0.003);
  EXPECT_NEAR(found.left_from_right.translation_m.x(), rig_.left_from_right.translation_m.x(),
              0.0005);
  EXPECT_NEAR(found.range_scale + found.range_offset_m, rig_.range_scale + rig_.range_offset_m,
              0.001);  // at 1 m

  const std::string report = FileText(folder_ / "report.html");
  EXPECT_THAT(report, HasSubstr("not good enough</span></h1>\n<ul>\n<li>"));
  EXPECT_THAT(report, HasSubstr("<h2>The rectified pair</h2>\n<figure><img"));
  EXPECT_THAT(report, HasSubstr("<h2>ToF points on the left image</h2>\n<figure><img"));
  EXPECT_THAT(report, ::testing::Not(HasSubstr("src=\"http")));
}

TEST_F(CalibrateProgram, LeavesTheRigFileWhenTheNewCalibrationIsNotGood) {
  RigDescription good;
  *good.mutable_calibration() = ToCalibration(rig_);
  ASSERT_TRUE(SaveRigFile(folder_ / "rig.textproto", good));
  const std::string before = FileText(folder_ / "rig.textproto");

  const MainOutcome outcome = RunCalibrate({"estimate", WriteLog("raw.lcm", 8), "--rig",
                                            File("rig.textproto"), "--out", File("rig.textproto")});

  EXPECT_EQ(outcome.exit_code, 1) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("calibration: not good enough"));
  EXPECT_EQ(FileText(folder_ / "rig.textproto"), before);
  EXPECT_TRUE(CalibrationOf(LoadRigFile(folder_ / "rig.not_good.textproto")));
}

TEST_F(CalibrateProgram, RefusesAnImageWhoseHeaderClaimsTooMuch) {
  for (const char* name : {"left_1.pgm", "right_1.pgm"}) {
    std::ofstream(folder_ / name) << "P5\n16384 16384\n255\n";
  }
  ExpectRefused({"estimate", folder_ / "", "--out", File("out.textproto")}, 2,
                "left_1.pgm: 16384x16384 px; allowed: 1 to 16384 px a side and 100000000 pixels");
}

TEST_F(CalibrateProgram, TakesFoldersOfImages) {
  const std::vector<Pose> poses = BoardPoses(board_, 8);
  for (uint32_t i = 0; i < poses.size(); ++i) {
    const RigImages images = scene_.Render(poses[i], i);
    const std::string name = std::to_string(i);
    cv::imwrite(File(("left_" + name + ".png").c_str()), images.left);
    cv::imwrite(File(("right_" + name + ".png").c_str()), images.right);
    cv::imwrite(File(("tof_amplitude_" + name + ".tiff").c_str()), images.tof.amplitude);
    cv::Mat depth_mm;
    images.tof.depth_m.convertTo(depth_mm, CV_16U, 1000);
    cv::imwrite(File(("tof_depth_" + name + ".png").c_str()), depth_mm);
  }
  const MainOutcome outcome =
      RunCalibrate({"estimate", folder_ / "", "--out", File("rig.textproto")});

  EXPECT_EQ(outcome.exit_code, 1) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("8 images: 8 views used"));
  const RawRig found =
      RequireCalibration(LoadRigFile(folder_ / "rig.not_good.textproto"), "the rig file");
  EXPECT_NEAR(found.left.fx / rig_.left.fx, 1, 0.003);
  EXPECT_EQ(found.tof.width, 176);

  std::filesystem::remove(folder_ / "right_3.png");
  const MainOutcome without =
      RunCalibrate({"estimate", folder_ / "", "--out", File("rig2.textproto")});
  EXPECT_THAT(without.out + without.err, HasSubstr("7 images: 7 views used"));
  EXPECT_THAT(without.err, HasSubstr("left_3.png: has no right image"));
}

// As ROS's camera_calibration saves them, and as many a program does.
TEST_F(CalibrateProgram, TakesImagesWithALineOrInFoldersOfTheirCameras) {
  for (const char* behind : {"-000", "/"}) {
    const TemporaryDirectory folder;
    for (const std::string side : {"left", "right"}) {
      std::filesystem::create_directories(folder / side);
      const uchar grey = side == "left" ? 10 : 20;
      for (const int i : {0, 1}) {
        cv::imwrite(folder / (side + behind + std::to_string(i) + ".png"),
                    cv::Mat1b(4, 6, static_cast<uchar>(grey + i)));
      }
    }
    std::vector<int> greys;
    const auto notes = ReadImageFolder(folder / "", 0, [&](const RigImages& images) {
      for (const cv::Mat& side : {images.left, images.right}) greys.push_back(side.at<uchar>(0, 0));
      EXPECT_TRUE(images.tof.depth_m.empty());
    });
    EXPECT_THAT(greys, testing::ElementsAre(10, 20, 11, 21)) << behind;
    EXPECT_THAT(notes, testing::IsEmpty());
  }
}

TEST_F(CalibrateProgram, SeesTheBoardInImagesWhosePixelsUse10Of16Bits) {
  const std::vector<Pose> poses = BoardPoses(board_, 8);
  for (uint32_t i = 0; i < poses.size(); ++i) {
    const std::string name = std::to_string(i);
    const RigImages images = scene_.Render(poses[i], i);
    cv::Mat left;
    cv::Mat right;
    images.left.convertTo(left, CV_16U, 4);
    images.right.convertTo(right, CV_16U, 4);
    cv::imwrite(File(("left_" + name + ".png").c_str()), left);
    cv::imwrite(File(("right_" + name + ".png").c_str()), right);
  }
  const MainOutcome outcome =
      RunCalibrate({"estimate", folder_ / "", "--out", File("rig.textproto")});
  EXPECT_THAT(outcome.out + outcome.err, HasSubstr("8 images: 8 views used"));
  EXPECT_THAT(outcome.err, HasSubstr("left_0.png: pixels of 16 bits use 0 to 1023"));
}

TEST_F(CalibrateProgram, SaysWhyAViewCannotBeWritten) {
  const RigImages images = scene_.Render(BoardPoses(board_, 1)[0], 0);
  EXPECT_THAT(Thrown<std::runtime_error>([&] { WriteImages(folder_ / "none", "1", images); }),
              EndsWith(": No such file or directory"));
}

TEST_F(CalibrateProgram, TellsACommandThatWorksWhereThereIsARigFileAndWhereThereIsNone) {
  const Board other{{.columns = 7, .rows = 5, .square_m = 0.0405}};
  const auto here = std::filesystem::current_path();
  std::filesystem::current_path(folder_ / ".");
  EXPECT_EQ(EstimateCommand(board_, "my views"),
            "sprout-calibrate estimate 'my views' --out rig.textproto --report report.html");
  EXPECT_EQ(EstimateCommand(other, "v"),
            "sprout-calibrate estimate v --squares 7x5 --square-mm 40.5 --out rig.textproto "
            "--report report.html");
  // As pasted: three views are too few, and nothing else is wrong.
  const std::vector<Pose> poses = BoardPoses(board_, 3);
  std::filesystem::create_directories("views");
  for (uint32_t i = 0; i < poses.size(); ++i) {
    WriteImages("views", std::to_string(i), scene_.Render(poses[i], i));
  }
  for (const bool has_rig : {false, true}) {
    if (has_rig) {
      EXPECT_TRUE(SaveRigFile("rig.textproto", RigDescription()));
    }
    wordexp_t argv{};
    ASSERT_EQ(wordexp(EstimateCommand(board_, "views").c_str(), &argv, WRDE_NOCMD), 0);
    const MainOutcome outcome = RunCalibrate({argv.we_wordv + 1, argv.we_wordv + argv.we_wordc});
    wordfree(&argv);
    EXPECT_EQ(outcome.exit_code, 1) << outcome.err;
    EXPECT_THAT(outcome.out + outcome.err, HasSubstr("views"));
  }
  std::filesystem::current_path(here);
}

TEST_F(CalibrateProgram, RefusesFlagsThatMakeNoSense) {
  ExpectRefused({}, 2, "which command?");
  ExpectRefused({"watch", "--channel-prefix", "a b", "--out", File("views")}, 2,
                "--channel-prefix 'a b': allowed are up to");
  ExpectRefused({"board", "--squares", "11", "--out", File("board.svg")}, 2,
                "--squares 11: allowed is COLUMNSxROWS");
  ExpectRefused({"board", "--squares", "11x8x", "--out", File("board.svg")}, 2, "COLUMNSxROWS");
  ExpectRefused({"board", "--squares", "99x99", "--out", File("board.svg")}, 2,
                "up to 500 squares");
  ExpectRefused({"board", "--square-mm", "nan", "--out", File("board.svg")}, 2, "--square-mm");
  ExpectRefused({"board", "--out", File("no/folder/board.svg")}, 2, "no/folder/board.svg");
  ExpectRefused({"estimate", File("none.lcm"), "--out", File("out.textproto")}, 2, "none.lcm");
  WriteBytes(folder_ / "empty.lcm", Bytes());
  for (const char* command : {"estimate", "check", "refine"}) {
    std::vector<std::string> arguments = {command, File("empty.lcm"), "--bits", "7"};
    if (command != std::string("check")) {
      arguments.insert(arguments.end(), {"--out", File("out.textproto")});
    }
    ExpectRefused(arguments, 2, "--bits 7: allowed: 8 to 16, or 0");
  }
}

TEST_F(CalibrateProgram, RefusesLogsWithoutRawImages) {
  std::vector<Event> events;
  WriteBytes(folder_ / "empty.lcm", MakeLog(events));
  ExpectRefused({"estimate", File("empty.lcm"), "--out", File("out.textproto")}, 2,
                "no whole frame of RAW_SPROUT_LEFT, RAW_SPROUT_RIGHT, RAW_SPROUT_TOF in it; it "
                "has no events");

  Append(scene_.Render(BoardPoses(board_, 1)[0], 0), 0, events);
  for (Event& event : events) event.channel = event.channel.substr(4);
  WriteBytes(folder_ / "rectified.lcm", MakeLog(events));
  ExpectRefused({"estimate", File("rectified.lcm"), "--out", File("out.textproto")}, 2,
                "it has SPROUT_LEFT (1), SPROUT_RIGHT (1), SPROUT_TOF (1)");

  WriteBytes(folder_ / "text.lcm", Bytes(1000, 'a'));
  ExpectRefused({"estimate", File("text.lcm"), "--out", File("out.textproto")}, 2, "text.lcm");
}

TEST_F(CalibrateProgram, SaysThatTheBoardIsNotThereOrAnotherOne) {
  std::vector<Event> events;
  RigImages images = scene_.Render(BoardPoses(board_, 1)[0], 0);
  images.left.setTo(100);
  images.right.setTo(100);
  Append(images, 0, events);
  WriteBytes(folder_ / "wall.lcm", MakeLog(events));
  ExpectRefused({"estimate", File("wall.lcm"), "--out", File("out.textproto")}, 1,
                "no image can be used (1 images: 0 views used, 1 without the board); found no "
                "board at all; looked for a ChArUco board of 9x6 squares with DICT_4X4_250 "
                "(--board, --squares, --dictionary)");
  ExpectRefused(
      {"estimate", WriteLog("ours.lcm", 2), "--dictionary", "DICT_6X6_250", "--out",
       File("out.textproto")},
      1, " markers of DICT_4X4_250; looked for a ChArUco board of 9x6 squares with DICT_6X6_250");

  const std::string log = WriteLog("raw.lcm", 3);
  ExpectRefused({"estimate", log, "--squares", "5x7", "--out", File("out.textproto")}, 1,
                "markers that do not lie as on a board of 5x7");
  ExpectRefused({"estimate", log, "--out", File("out.textproto")}, 1,
                "the left camera sees 6 corners of the board in 3 views: 5 are needed at least");
}

TEST_F(CalibrateProgram, SaysEarlyThatTheBoardIsAnotherOne) {
  const MainOutcome outcome = RunCalibrate(
      {"estimate", WriteLog("raw.lcm", 5), "--squares", "5x7", "--out", File("out.textproto")});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.err,
              testing::AllOf(
                  HasSubstr("the first 4 images are without the board: found 27 markers of "
                            "DICT_4X4_250; looked for a ChArUco board of 5x7 squares"),
                  HasSubstr("no image can be used (5 images: 0 views used, 5 without the board")));
}

}  // namespace
}  // namespace sprout::calibrate
