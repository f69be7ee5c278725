#include "services/view/target_panel.h"

#include <gmock/gmock.h>

#include "tests/services/view/view_frames.h"

namespace sprout::view {
namespace {

using ::testing::HasSubstr;

// The frame of a ring that came last, decoded.
DecodedFrame NewestOf(const RingInput& input) {
  return DecodedFrame(input.ring.Newest(), [](Part, const std::string&) {});
}

std::string FigureText(const nlohmann::json& answer, const std::string& name) {
  for (const nlohmann::json& figure : answer["figures"]) {
    if (figure["name"] == name) return figure["text"];
  }
  return "";
}

TEST(TargetPanel, HasTheFiguresOfTheRegionOverTheFramesThatAreShown) {
  RingInput input;
  TargetPanel panel({.region = cv::Rect(0, 0, 64, 48), .distance_m = 1.0});
  for (int64_t seq = 0; seq < 3; ++seq) {
    AddWhole(input, seq);
    DecodedFrame frame = NewestOf(input);
    panel.Show(frame);
    panel.Show(frame);  // drawn again, for another size of the window
  }
  DecodedFrame frame = NewestOf(input);
  const nlohmann::json answer = panel.Show(frame);
  EXPECT_EQ(answer["frames"], 3);
  EXPECT_EQ(answer["region"], nlohmann::json({0, 0, 64, 48}));
  EXPECT_EQ(answer.contains("error"), false);
  EXPECT_EQ(FigureText(answer, "fill_rate_percent"), "98.44 %");  // all but one of 64 columns
  EXPECT_EQ(FigureText(answer, "subpixel_rms_px"), "0.0000 px");
  EXPECT_EQ(FigureText(answer, "temporal_noise_mm"), "0.000 mm");
  EXPECT_NE(FigureText(answer, "z_accuracy_percent"), "");
}

TEST(TargetPanel, SaysWhyThereIsNothingToMeasure) {
  RingInput input;
  const auto why = [&](const TargetSettings& settings) -> std::string {
    DecodedFrame frame = NewestOf(input);
    return TargetPanel(settings).Show(frame).value("error", "");
  };
  input.Add(0, Part::kLeft, ViewImage(1));
  EXPECT_THAT(why({}), HasSubstr("no disparity map"));
  input.Add(0, Part::kDisparity, ViewMap());
  EXPECT_THAT(why({}), HasSubstr("calibration"));
  input.Add(0, Part::kRig, ViewRig());
  EXPECT_EQ(why({}), "");
  EXPECT_THAT(why({.region = cv::Rect(40, 40, 60, 60)}), HasSubstr("allowed is a rectangle"));
  input.Add(1, Part::kLeft, ViewImage(1));
  input.Add(1, Part::kDisparity, DisparityImage(kViewSize));
  EXPECT_THAT(why({}), HasSubstr("no plane"));
}

TEST(TargetPanel, BeginsAnewWithAnotherCalibration) {
  RingInput input;
  TargetPanel panel(TargetSettings{});
  AddWhole(input, 0);
  DecodedFrame first = NewestOf(input);
  EXPECT_EQ(panel.Show(first)["frames"], 1);
  RingInput other;
  Rig rig = ViewRig();
  rig.pair.focal_px = 60;
  other.Add(1, Part::kRig, rig);
  other.Add(1, Part::kDisparity, ViewMap());
  DecodedFrame second = NewestOf(other);
  EXPECT_EQ(panel.Show(second)["frames"], 1);
}

}  // namespace
}  // namespace sprout::view
