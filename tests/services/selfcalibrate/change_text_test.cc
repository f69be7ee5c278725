#include <gmock/gmock.h>

#include "services/selfcalibrate/rig_watch.h"

// The texts about a change, for people.
namespace sprout::selfcalibrate {
namespace {

using testing::HasSubstr;
using Verdict = RigChange::Verdict;

constexpr RectifiedPair kPair{.width = 640, .height = 480, .focal_px = 500, .baseline_m = 0.1};

RigChange Wrong() {
  return {.newest_frame = {},
          .reason = {},
          .verdict = RigChange::Verdict::kWrong,
          .frames = 10,
          .matches = 1500,
          .tof_matches = 200,
          .rows_px = -0.5F,
          .rows_spread_px = 0.25F,
          .rows_sigma_px = 0.01F,
          .right = {.turn = {0.001, -0.002, 0.01}, .sigma = {0.0001, 0.0002, 0.001}},
          .tof = {.turn = {0.004, 0.006, 0}, .sigma = {0.0004, 0.0008, -1}},
          .range_offset_m = 0.012,
          .range_sigma_m = 0.001};
}

TEST(ChangeText, HasEveryFigureWithItsStandardDeviation) {
  EXPECT_EQ(ChangeText(Wrong(), kPair),
            "the calibration is wrong (10 frames, 1500 matches): rows -0.50 ± 0.01 px (spread 0.25 "
            "px), right camera pitch +0.50 ± 0.05 px, yaw -1.00 ± 0.10 px, roll +0.573 ± 0.057 °; "
            "ToF camera pitch +2.00 ± 0.20 px, yaw +3.00 ± 0.40 px, roll not seen, ranges +12.0 ± "
            "1.0 mm");
}

TEST(ChangeText, SaysWhereATurnMayBeAMove) {
  RigChange change = Wrong();
  EXPECT_THAT(ChangeText(change, kPair), testing::Not(HasSubstr("moved some mm")));
  change.tof.sigma[1] = 0.0025;
  EXPECT_THAT(ChangeText(change, kPair),
              HasSubstr("yaw +3.00 ± 1.25 px, roll not seen (turned, or moved some mm"));
}

TEST(ChangeText, SaysWhyNothingIsSeen) {
  const RigChange change{.newest_frame = {}, .reason = "the scene is too flat", .frames = 4};
  EXPECT_EQ(ChangeText(change, kPair),
            "no calibration can be told from 4 frames: the scene is too flat");
}

TEST(ChangeText, AdvisesACommandUnlessCaptureDoesIt) {
  EXPECT_THAT(AdviceText(/*applied=*/false),
              testing::HasSubstr("sprout-record --dir recording --seconds 10; sprout-calibrate "
                                 "refine recording/*.lcm --out new.textproto"));
  EXPECT_EQ(AdviceText(/*applied=*/true), "capture is asked to put it right");
}

TEST(CurveText, HasTheNearestTheFarthestAndTheMostWithTheCommand) {
  const std::string command =
      ": sprout-record --dir recording --seconds 10; sprout-calibrate refine recording/*.lcm --out "
      "new.textproto --rig FILE writes that into the rig file";
  EXPECT_EQ(
      CurveText({{1, 0.004, 0.001}, {1.2, 0.001, 0.001}, {1.5, -0.0123, 0.0021}, {2, 0.01, 0.001}}),
      "the ToF camera's ranges lack +4.0 ± 1.0 mm at 1.00 m, -12.3 ± 2.1 mm at 1.50 m, +10.0 ± "
      "1.0 mm at 2.00 m" +
          command);
  EXPECT_EQ(CurveText({{1.5, -0.0098, 0.0006}}),
            "the ToF camera's ranges lack -9.8 ± 0.6 mm" + command);
}

TEST(OffsetOf, IsTheShiftOfTheToFCamerasPoints) {
  const TofOffsetStatus offset = OffsetOf(Wrong(), kPair);
  EXPECT_FLOAT_EQ(offset.u_px, 3);
  EXPECT_FLOAT_EQ(offset.v_px, -2);
  EXPECT_FLOAT_EQ(offset.sigma_px, 0.4F);
  EXPECT_FALSE(offset.is_off);  // the warning is another one
  RigChange unseen = Wrong();
  unseen.tof.sigma[1] = -1;
  EXPECT_EQ(OffsetOf(unseen, kPair).sigma_px, -1);
}

}  // namespace
}  // namespace sprout::selfcalibrate
