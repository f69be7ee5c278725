#include "services/refine/findings.h"

#include <gtest/gtest.h>

#include <limits>
#include <optional>
#include <string>

namespace sprout::refine {
namespace {

std::optional<std::string> TextOf(const RangeError& error) {
  RefineFindings found;
  found.range_error = error;
  return FindingText(found);
}

TEST(RefineFindings, SaysWhatTheSensorIsOffByInMillimetresAndWhatShareWasMoved) {
  const RangeError error{.curve = {{0.9, 0.001, 0.002},  // not sure
                                   {1.2, 0.0102, 0.0008},
                                   {1.6, -0.0151, 0.0005},
                                   {2.0, 0.008, 0.001},
                                   {2.5, 0.02, std::numeric_limits<double>::infinity()}},
                         .curve_is_zero = false,
                         .far_moved_share = 0.634};
  EXPECT_EQ(TextOf(error),
            "depths of the range sensor are off by +10.2 ± 0.8 mm at 1.20 m, -15.1 ± 0.5 mm at "
            "1.60 m, +8.0 ± 1.0 mm at 2.00 m; 63 % of its points were moved by more than "
            "0.25 px. If that stays so: sprout-calibrate refine");
}

TEST(RefineFindings, NamesThePairWhereAllIsOffByTheSamePx) {
  const RangeError error{.curve = {{1.2, 0.0102, 0.0008}, {2.4, 0.0408, 0.0016}},
                         .curve_is_zero = false,
                         .same_px = 1.96,
                         .far_moved_share = 1};
  EXPECT_EQ(TextOf(error),
            "depths of the range sensor are off by +10.2 ± 0.8 mm at 1.20 m, +40.8 ± 1.6 mm at "
            "2.40 m, about +2.0 px at all depths, as if not the sensor but the right camera of the "
            "pair were turned; 100 % of its points were moved by more than 0.25 px. If that stays "
            "so: sprout-calibrate refine");
}

TEST(RangeError, IsBeyondDataSheetsFromTwoPercentOfTheDepthOn) {
  RangeError error{.curve = {{1.2, 0.02, 0.001}, {3.0, -0.061, 0.002}}, .curve_is_zero = false};
  EXPECT_TRUE(error.IsBeyondDataSheets());
  error.curve.back().error_m = -0.059;
  EXPECT_FALSE(error.IsBeyondDataSheets());
  EXPECT_FALSE(RangeError().IsBeyondDataSheets());
}

TEST(RefineFindings, DoubtsWhatIsOffByAPxAtAllDepths) {
  SeedSet seeds;
  seeds.seeds.resize(1);
  const auto text = [&](double px) {
    RefineFindings found;
    found.range_error.same_px = px;
    return DegenerateText(found, seeds, /*stereo_seeds=*/true);
  };
  EXPECT_EQ(text(0.9), "");
  EXPECT_EQ(text(-2.04),
            "range sensor and pair differ by about -2.0 px at all depths, as where the right "
            "camera is turned: one frame cannot tell which of them is wrong, and the images were "
            "believed");
}

TEST(RefineFindings, SaysEachDepthOnceAndTheSurestIfNoneIsSure) {
  RangeError error{.curve = {{1.2, 0.0102, 0.0008}, {1.6, 0.005, 0.0005}},
                   .curve_is_zero = false,
                   .far_moved_share = 1};
  const std::string two = TextOf(error).value();
  EXPECT_NE(two.find("by +10.2 ± 0.8 mm at 1.20 m, +5.0 ± 0.5 mm at 1.60 m; 100 %"),
            std::string::npos)
      << two;
  error.curve = {{1.2, 0.002, 0.002}, {1.6, 0.002, 0.001}, {2.0, 0, 0.0005}};
  const std::string one = TextOf(error).value();
  EXPECT_NE(one.find("by +2.0 ± 1.0 mm at 1.60 m; 100 %"), std::string::npos) << one;
  // Nothing to calibrate.
  error.curve = {{1.2, 0.002, 0.003}, {1.6, 0, 0.001}};
  EXPECT_EQ(TextOf(error),
            "the range sensor is off, at no depth for sure: 100 % of its points were moved by more "
            "than 0.25 px");
}

TEST(RefineFindings, TellsNothingKnownFromNothingWrongAndFromWhatTheSceneAdds) {
  EXPECT_EQ(TextOf({}), std::nullopt);
  RangeError error{.curve = {{1.2, 0, 0.001}}};
  EXPECT_EQ(TextOf(error), "");
  error.far_moved_share = 0.004;
  EXPECT_EQ(TextOf(error), "");
  error.far_moved_share = 0.2;
  EXPECT_EQ(TextOf(error),
            "the range sensor is off as by multi-path: 20 % of its points were moved by more than "
            "0.25 px");
  error.rejected = true;
  EXPECT_EQ(TextOf(error), std::nullopt);
}

}  // namespace
}  // namespace sprout::refine
