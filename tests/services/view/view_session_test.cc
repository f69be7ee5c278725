#include "services/view/view_session.h"

#include <gmock/gmock.h>

#include "tests/services/view/view_frames.h"

namespace sprout::view {
namespace {

using ::testing::HasSubstr;

class ViewSessionTest : public ::testing::Test {
 protected:
  ViewSessionTest() {
    for (int64_t seq = 0; seq < 10; ++seq) AddWhole(input_, seq);
  }

  void Say(const std::string& message) {
    const auto understood = session_.OnMessage(message);
    EXPECT_TRUE(understood) << understood.error().text;
  }

  // Sequence number of the frame that is sent now; −1: none.
  int64_t Sent() {
    const auto show = session_.TakeFrame();
    return show ? show->frame->id.seq : -1;
  }

  RingInput input_;
  PausedFrameBudget budget_{size_t{64} << 20};
  ViewSession session_{input_.ring, budget_};
};

TEST_F(ViewSessionTest, GetsTheNewestFrameWheneverItHasDrawnTheLast) {
  EXPECT_EQ(Sent(), 9);
  AddWhole(input_, 10);
  AddWhole(input_, 11);
  EXPECT_EQ(Sent(), -1);
  Say(R"({"type":"drawn"})");
  EXPECT_EQ(Sent(), 11);
  Say(R"({"type":"drawn"})");
  EXPECT_EQ(Sent(), -1);
}

TEST_F(ViewSessionTest, KeepsItsFramesWhileItLooks) {
  EXPECT_EQ(Sent(), 9);
  Say(R"({"type":"drawn"})");
  Say(R"({"type":"pause"})");
  for (int64_t seq = 10; seq < 200; ++seq) AddWhole(input_, seq);
  EXPECT_EQ(Sent(), -1);
  EXPECT_EQ(session_.keys(), (KeyRange{0, 9}));
  EXPECT_EQ(input_.ring.Get(3), nullptr);
  Say(R"({"type":"look","key":3})");
  EXPECT_EQ(Sent(), 3);
  Say(R"({"type":"drawn"})");
  Say(R"({"type":"live"})");
  EXPECT_EQ(Sent(), 199);
}

TEST_F(ViewSessionTest, KeepsNoMoreThanTheBudgetOfAllPages) {
  PausedFrameBudget small(3 * input_.ring.Newest()->bytes());
  ViewSession first(input_.ring, small);
  ViewSession second(input_.ring, small);
  ASSERT_TRUE(first.OnMessage(R"({"type":"pause"})"));
  ASSERT_TRUE(second.OnMessage(R"({"type":"pause"})"));
  EXPECT_EQ(first.keys(), (KeyRange{7, 9}));
  EXPECT_EQ(second.keys(), (KeyRange{0, 9}));  // those of the ring, as long as it has them
  ASSERT_TRUE(first.OnMessage(R"({"type":"live"})"));
  ASSERT_TRUE(second.OnMessage(R"({"type":"live"})"));
  ASSERT_TRUE(second.OnMessage(R"({"type":"pause"})"));
  EXPECT_EQ(second.keys(), (KeyRange{7, 9}));
}

TEST_F(ViewSessionTest, SaysThatAFrameIsGone) {
  Say(R"({"type":"look","key":77})");
  EXPECT_EQ(Sent(), -1);
  EXPECT_EQ(session_.TakeGone(), 77);
  EXPECT_EQ(session_.TakeGone(), std::nullopt);
}

TEST_F(ViewSessionTest, SendsTheFrameAgainForAnotherWish) {
  EXPECT_EQ(Sent(), 9);
  Say(R"({"type":"drawn"})");
  Say(R"({"type":"wish","pictures":{"left":99999,"depth":64},"cloud":true})");
  const auto show = session_.TakeFrame().value();
  EXPECT_THAT(show.parts.pictures, ::testing::UnorderedElementsAre(std::pair(Picture::kLeft, 4096),
                                                                   std::pair(Picture::kDepth, 64)));
  EXPECT_TRUE(show.parts.cloud);
  EXPECT_FALSE(show.parts.seeds);
}

TEST_F(ViewSessionTest, TellsOfThePixelThatWasAskedForLast) {
  Say(R"({"type":"probe","u":1,"v":2})");
  EXPECT_FALSE(session_.TakeProbe());  // no frame was sent yet
  EXPECT_EQ(Sent(), 9);
  Say(R"({"type":"probe","u":3,"v":4})");
  const auto probe = session_.TakeProbe().value();
  EXPECT_EQ(probe.u, 3);
  EXPECT_EQ(probe.frame->id.seq, 9);
  EXPECT_FALSE(session_.TakeProbe());
}

TEST_F(ViewSessionTest, MeasuresEachFrameThatIsSentOnce) {
  Say(R"({"type":"measure","region":[4,4,40,30],"edge":[8,8,9,9],"distance_m":1.5})");
  EXPECT_FALSE(session_.TakeMeasure());  // no frame was sent yet
  EXPECT_EQ(Sent(), 9);
  const auto measure = session_.TakeMeasure().value();
  EXPECT_EQ(measure.frame->id.seq, 9);
  EXPECT_FALSE(session_.TakeMeasure());
  Say(R"({"type":"drawn"})");
  AddWhole(input_, 10);
  EXPECT_EQ(Sent(), 10);
  EXPECT_EQ(session_.TakeMeasure()->panel, measure.panel);
  // Another region begins anew, on the frame that is there.
  Say(R"({"type":"measure"})");
  const auto other = session_.TakeMeasure().value();
  EXPECT_NE(other.panel, measure.panel);
  Say(R"({"type":"measure","off":true})");
  Say(R"({"type":"drawn"})");
  AddWhole(input_, 11);
  EXPECT_EQ(Sent(), 11);
  EXPECT_FALSE(session_.TakeMeasure());
}

TEST_F(ViewSessionTest, RefusesWhatNoPageOfOursSays) {
  for (const char* bad : {"",
                          "{",
                          "[]",
                          "7",
                          R"({"type":"fly"})",
                          R"({"type":7})",
                          R"({"type":"look"})",
                          R"({"type":"look","key":"x"})",
                          R"({"type":"look","key":1.5})",
                          R"({"type":"wish"})",
                          R"({"type":"wish","pictures":{"secret":64}})",
                          R"({"type":"wish","pictures":{"left":"x"}})",
                          R"({"type":"measure","region":[1,2,3]})",
                          R"({"type":"measure","region":[1,2,3,"x"]})",
                          R"({"type":"measure","edge":[-1,2,3,4]})",
                          R"({"type":"measure","region":[1,2,3,99999]})",
                          R"({"type":"measure","distance_m":0})",
                          R"({"type":"measure","distance_m":"x"})",
                          R"({"type":"probe","u":-1,"v":0})",
                          R"({"type":"probe","u":0,"v":99999})",
                          "\xff\xfe"}) {
    EXPECT_FALSE(session_.OnMessage(bad)) << bad;
  }
}

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
