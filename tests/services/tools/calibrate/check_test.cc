#include <gmock/gmock.h>
#include <wordexp.h>

#include <filesystem>

#include "common/bus/channels.h"
#include "common/messages/codec.h"
#include "common/rig/rig_file.h"
#include "common/scenes/dataset.h"
#include "services/tools/calibrate/image_folder.h"
#include "services/tools/calibrate/program.h"
#include "tests/common/app/run_main.h"
#include "tests/common/logfile/sample_log.h"
#include "tests/services/tools/calibrate/board_scene.h"
#include "tests/services/tools/calibrate/knocked_scene.h"

namespace sprout::calibrate {
namespace {

using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::Not;

class CalibrateCheck : public testing::Test {
 protected:
  // A log of a dataset whose right images are moved down by some rows.
  std::string WriteLog(const std::string& source, int frames, int rows_down) const {
    const std::unique_ptr<scenes::Dataset> dataset = scenes::OpenDataset(source);
    std::vector<Event> events;
    for (int i = 0; i < frames; ++i) {
      const scenes::DatasetFrame frame = dataset->Get(i);
      cv::Mat right = frame.right.clone();
      if (rows_down > 0) {
        frame.right.rowRange(0, right.rows - rows_down)
            .copyTo(right.rowRange(rows_down, right.rows));
      }
      const FrameId id{
          .utime = 1'700'000'000'000'000 + 100'000 * i, .seq = i, .rig_id = RigId(dataset->rig())};
      const auto add = [&](Part part, const PartValue& value) {
        events.push_back({.utime = id.utime,
                          .channel = std::string(ChannelOf(part)),
                          .data = EncodePart(id, part, value)});
      };
      add(Part::kRig, dataset->rig());
      add(Part::kLeft, frame.left);
      add(Part::kRight, right);
      add(Part::kTof, frame.tof);
    }
    WriteBytes(folder_ / "run.lcm", MakeLog(events));
    return folder_ / "run.lcm";
  }

  static MainOutcome Check(const std::string& log) { return RunCalibrate("check " + log); }

  // Words as a shell makes them.
  static MainOutcome RunCalibrate(const std::string& words) {
    wordexp_t argv{};
    EXPECT_EQ(wordexp(("sprout-calibrate " + words).c_str(), &argv, WRDE_NOCMD), 0) << words;
    const MainOutcome outcome =
        RunMain({argv.we_wordv, argv.we_wordv + argv.we_wordc}, CalibrateMain);
    wordfree(&argv);
    return outcome;
  }

  MainOutcome CheckFolderWithRig() const {
    RigDescription description;
    *description.mutable_calibration() = ToCalibration(rig_);
    EXPECT_TRUE(SaveRigFile(folder_ / "rig.textproto", description));
    return RunCalibrate("check " + (folder_ / ".").string() + " --rig " +
                        (folder_ / "rig.textproto").string());
  }

  // Output for a frame that does not show whether the rig is right.
  std::string OutOfUndecided(const RigImages& images) const {
    WriteImages(folder_ / ".", "0", images);
    const MainOutcome outcome = CheckFolderWithRig();
    EXPECT_EQ(outcome.exit_code, 1);
    EXPECT_THAT(outcome.out, Not(HasSubstr("to put it right")));
    return outcome.out;
  }

  const TemporaryDirectory folder_;
  const RawRig rig_ = SceneRig({640, 480});
};

TEST_F(CalibrateCheck, FindsNothingWrongWithAGoodRig) {
  const MainOutcome outcome = Check(WriteLog("synthetic:640x480?tof=sr4000", 4, 0));

  EXPECT_EQ(outcome.exit_code, 0) << outcome.out << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("4 frames: good\n"));
}

TEST_F(CalibrateCheck, NoticesAToFCameraThatWasKnocked) {
  const MainOutcome outcome = Check(WriteLog("synthetic:640x480?tof=sr4000&calibration=5", 4, 0));

  EXPECT_EQ(outcome.exit_code, 1) << outcome.out << outcome.err;
  EXPECT_THAT(outcome.out, ContainsRegex("ToF points are (4.[5-9]|5.[0-5]) px beside .*was the "
                                         "ToF camera knocked."));

  // What it tells to do works where there is no rig file.
  const std::string hint = "to put it right without a board: sprout-calibrate ";
  const size_t begin = outcome.out.find(hint);
  ASSERT_NE(begin, std::string::npos) << outcome.out;
  const auto here = std::filesystem::current_path();
  std::filesystem::current_path(folder_ / ".");
  const MainOutcome refined = RunCalibrate(
      outcome.out.substr(begin + hint.size(), outcome.out.find('\n', begin) - begin - hint.size()));
  std::filesystem::current_path(here);
  EXPECT_NE(refined.exit_code, 2) << refined.err;
  EXPECT_TRUE(std::filesystem::exists(folder_ / "new.textproto") ||
              std::filesystem::exists(folder_ / "new.not_good.textproto"))
      << refined.out << refined.err;
}

TEST_F(CalibrateCheck, TakesFoldersOfUnrectifiedImagesWithARigFile) {
  const Board board{BoardSize{}};
  const BoardScene scene(board, rig_);
  const std::vector<Pose> poses = BoardPoses(board, 3);
  for (uint32_t i = 0; i < poses.size(); ++i) {
    WriteImages(folder_ / ".", std::to_string(i), scene.Render(poses[i], i));
  }
  const MainOutcome with_rig = CheckFolderWithRig();
  EXPECT_EQ(with_rig.exit_code, 0) << with_rig.out << with_rig.err;
  EXPECT_THAT(with_rig.out, HasSubstr("3 frames: good\n"));
  const MainOutcome without = RunCalibrate("check " + (folder_ / ".").string());
  EXPECT_EQ(without.exit_code, 2);
  EXPECT_THAT(without.err, HasSubstr("are not rectified: --rig is needed"));
}

// Without a verdict the exit code is not 0.
TEST_F(CalibrateCheck, SaysWhenASceneDoesNotTell) {
  cv::Mat1b wall(480, 640);  // brighter to one side, and no corner
  for (int u = 0; u < wall.cols; ++u) wall.col(u).setTo(60 + u / 10);
  EXPECT_THAT(OutOfUndecided({.left = wall, .right = wall, .tof = {}}),
              HasSubstr("1 frames: cannot tell\n  * too little to see: 0 matches"));
}

// A covered lens cannot be corrected by a calibration.
TEST_F(CalibrateCheck, CannotTellFromABlankImage) {
  const Board board{BoardSize{}};
  auto images = BoardScene(board, rig_).Render(BoardPoses(board, 1)[0], 0);
  images.right.setTo(100);
  const std::string out = OutOfUndecided(images);
  EXPECT_THAT(out, HasSubstr("1 frames: cannot tell: the images are wrong\n"));
  EXPECT_THAT(out, HasSubstr("the right image is blank"));
}

// Neither can different exposures: refine would change nothing.
TEST_F(CalibrateCheck, CannotTellFromTwoContrasts) {
  RigImages images = RenderScene(rig_, 3, 0, false);
  images.right = 0.5 * images.right + 10;
  const std::string out = OutOfUndecided(images);
  EXPECT_THAT(out, HasSubstr("1 frames: cannot tell: the images are wrong\n"));
  EXPECT_THAT(out, HasSubstr("times the contrast in the right one"));
}

TEST_F(CalibrateCheck, NoticesRowsThatDoNotAgree) {
  const MainOutcome outcome = Check(WriteLog("synthetic:640x480?tof=none", 2, 2));

  EXPECT_EQ(outcome.exit_code, 1) << outcome.out << outcome.err;
  EXPECT_THAT(outcome.out, ContainsRegex("rows of the right image lie .(1.9|2.0)"));
  EXPECT_THAT(outcome.out, Not(HasSubstr("ToF")));
}

// More rows than windows around seeds are searched: a right camera that was pitched.
TEST_F(CalibrateCheck, NoticesRowsThatAreFarOff) {
  const MainOutcome outcome = Check(WriteLog("synthetic:640x480?tof=none", 2, 10));

  EXPECT_EQ(outcome.exit_code, 1) << outcome.out << outcome.err;
  EXPECT_THAT(outcome.out, ContainsRegex("rows of the right image lie .(9.9|10.0)"));
}

}  // namespace
}  // namespace sprout::calibrate
