#include "services/tools/calibrate/coverage.h"

#include <gmock/gmock.h>

#include <numbers>

#include "tests/services/tools/calibrate/board_scene.h"

namespace sprout::calibrate {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::Not;

class CoverageTest : public testing::Test {
 protected:
  void Add(const Pose& pose) {
    BoardView view = scene_.Project(pose, 0.05, ++seed_);
    coverage_.Add(view, sizes_);
  }

  // Straight ahead, turned about the x or y axis through its middle.
  void AddTurned(const Eigen::Vector3d& axis, double degrees, double distance_m = 1) {
    const Eigen::Vector2d middle = board_.extent_m() / 2;
    Pose pose;
    pose.rotation = Eigen::AngleAxisd(degrees * std::numbers::pi / 180, axis);
    pose.translation_m = Eigen::Vector3d(0.05, 0, distance_m) -
                         pose.rotation * Eigen::Vector3d(middle.x(), middle.y(), 0);
    Add(pose);
  }

  const Board board_{BoardSize{}};
  const RawRig rig_ = SceneRig({640, 480});
  const BoardScene scene_{board_, rig_};
  const std::array<cv::Size, kCameraCount> sizes_ = {rig_.left.size(), rig_.right.size(),
                                                     rig_.tof.size()};
  Coverage coverage_{board_};
  uint32_t seed_ = 0;
};

TEST_F(CoverageTest, HasNothingToComplainOfWhenTheBoardWasEverywhere) {
  for (const Pose& pose : BoardPoses(board_, 30)) Add(pose);
  EXPECT_THAT(coverage_.Missing(), testing::IsEmpty()) << coverage_.Text();
  EXPECT_EQ(coverage_.views(kLeft), 30);
  EXPECT_THAT(coverage_.Text(), HasSubstr("views     30"));
}

TEST_F(CoverageTest, SaysAllThatIsMissingAtTheBegin) {
  AddTurned(Eigen::Vector3d::UnitX(), 0);
  const std::vector<std::string> missing = coverage_.Missing();
  EXPECT_THAT(missing, Contains("the right camera has 1 views of 15 or more"));
  EXPECT_THAT(missing,
              Contains("the left image's upper left ninth has no corner: show the board there"));
  EXPECT_THAT(missing, Contains(HasSubstr("its upper edge nearer (0 of 2)")));
  EXPECT_THAT(missing, Contains(HasSubstr("nearer and farther")));
  EXPECT_THAT(missing, Not(Contains(HasSubstr("left image's middle ninth"))));
}

TEST_F(CoverageTest, TellsHowTheBoardIsTilted) {
  // Right-handed, y down: about x the lower edge goes away, about y the right edge comes nearer.
  AddTurned(Eigen::Vector3d::UnitX(), 25);
  AddTurned(Eigen::Vector3d::UnitY(), 25);
  AddTurned(Eigen::Vector3d::UnitY(), 30);
  AddTurned(Eigen::Vector3d::UnitY(), 5);
  EXPECT_EQ(coverage_.tilted(Coverage::kUpperNearer), 1);
  EXPECT_EQ(coverage_.tilted(Coverage::kLowerNearer), 0);
  EXPECT_EQ(coverage_.tilted(Coverage::kRightNearer), 2);
  EXPECT_EQ(coverage_.tilted(Coverage::kLeftNearer), 0);
}

TEST_F(CoverageTest, SeesDistancesWithoutACalibration) {
  AddTurned(Eigen::Vector3d::UnitX(), 10, 0.8);
  AddTurned(Eigen::Vector3d::UnitX(), 10, 0.9);
  EXPECT_THAT(coverage_.Missing(), Contains(HasSubstr("nearer and farther")));
  AddTurned(Eigen::Vector3d::UnitX(), 10, 1.2);
  EXPECT_THAT(coverage_.Missing(), Not(Contains(HasSubstr("nearer and farther"))));
  EXPECT_THAT(coverage_.Text(), testing::ContainsRegex("farthest  1[.][45]"));
}

TEST_F(CoverageTest, AsksForNoToFCameraThatIsNotThere) {
  BoardView view = scene_.Project(BoardPoses(board_, 1)[0], 0.05, 1);
  view.tof = {};
  view.corners[kTof] = {};
  coverage_.Add(view, {sizes_[kLeft], sizes_[kRight], cv::Size()});
  EXPECT_THAT(coverage_.Missing(), Not(Contains(HasSubstr("ToF"))));
  EXPECT_THAT(coverage_.Text(), Not(HasSubstr("ToF")));
}

}  // namespace
}  // namespace sprout::calibrate
