#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "services/tools/evaluate/run_pictures.h"
#include "services/tools/evaluate/tables.h"

namespace sprout::evaluate {
namespace {

using Json = nlohmann::ordered_json;

Accuracy SomeAccuracy() {
  return {.scored = 200,
          .with_disparity = 180,
          .within_half = 120,
          .within_1 = 150,
          .below_1 = 140,
          .within_2 = 160,
          .within_4 = 170,
          .within_d1 = 165,
          .sum_abs_px = 90,
          .sum_squares_px2 = 720};
}

MethodResult SomeMethod(const std::string& name) {
  return {.name = name,
          .nonoccluded = SomeAccuracy(),
          .all = {.scored = 400},
          .ms = {.refine_ms = 1, .prior_ms = 2, .grow_ms = 3, .fill_ms = 4, .total_ms = 10}};
}

RunResult SomeRun() {
  SceneResult scene{.name = "Monopoly", .size = {30, 20}};
  scene.methods = {SomeMethod("epc"), SomeMethod("fgs")};
  scene.refinement.refined = {.seeds = std::vector<Seed>(160),
                              .raw = 200,
                              .outside = 5,
                              .dark = 10,
                              .loose = 3,
                              .background = 20,
                              .hidden = 2,
                              .contradicted = 4};
  for (size_t i = 0; i < 4; ++i) scene.refinement.refined.seeds[i].origin = SeedOrigin::kStereo;
  scene.refinement.before = {.good = 150, .wrong = 40};
  scene.refinement.after = {.good = 144, .wrong = 8};
  scene.refinement.good_lost = 9;
  return {.preset = "paper", .tof = "grid:auto", .scenes = {scene}};
}

TEST(ResultFiles, JsonHasTheDocumentedShape) {
  const Json expected = Json::parse(R"({
    "preset": "paper", "tof": "grid:auto",
    "scenes": [{
      "name": "Monopoly", "width": 30, "height": 20,
      "methods": [{
        "name": "epc",
        "nonocc": {"correct_le1": 75.0, "correct_lt1": 70.0, "bad2": 20.0, "bad4": 15.0,
                   "density": 90.0, "mean_abs_px": 0.5, "rms_px": 2.0, "bad05": 40.0,
                   "d1": 17.5},
        "all": {"correct_le1": 0.0, "correct_lt1": 0.0, "bad2": 100.0, "bad4": 100.0,
                "density": 0.0, "mean_abs_px": null, "rms_px": null, "bad05": 100.0,
                "d1": 100.0},
        "away": {"correct_le1": null, "correct_lt1": null, "bad2": null, "bad4": null,
                 "density": null, "mean_abs_px": null, "rms_px": null, "bad05": null,
                 "d1": null},
        "ms": {"refine": 1.0, "prior": 2.0, "grow": 3.0, "fill": 4.0, "total": 10.0}
      }],
      "refinement": {"raw": 200, "outside": 5, "dark": 10, "loose": 3, "background": 20,
                     "hidden": 2, "contradicted": 4, "kept": 156, "stereo": 4,
                     "wrong_before": 20.0, "wrong_after": 5.0, "good_lost": 6.0}
    }]})");
  RunResult run = SomeRun();
  run.scenes[0].methods.resize(1);
  EXPECT_EQ(Json::parse(ToJson(run)).dump(2), expected.dump(2));  // the order of keys, too
}

TEST(ResultFiles, JsonHasTheCurveOfAMethodWithAConfidence) {
  RunResult run = SomeRun();
  Sparsification& curve = run.scenes[0].methods[1].confidence.emplace();
  curve.bad1_percent.back() = 8;
  curve.area_percent = 2;
  curve.oracle_area_percent = 1;
  const Json methods = Json::parse(ToJson(run))["scenes"][0]["methods"];
  EXPECT_FALSE(methods[0].contains("confidence"));
  const Json& json = methods[1]["confidence"];
  EXPECT_EQ(json["kept"].size(), 20u);
  EXPECT_EQ(json["kept"][0], 5);
  EXPECT_EQ(json["bad1"].size(), 20u);
  EXPECT_EQ(json["bad1"][19], 8.0);
  EXPECT_EQ(json["area"], 2.0);
  EXPECT_EQ(json["oracle_area"], 1.0);
}

TEST(ResultFiles, JsonSurvivesNamesThatAreNoText) {
  RunResult run = SomeRun();
  run.scenes[0].name = "\xff\"\n";
  EXPECT_TRUE(Json::accept(ToJson(run)));
}

TEST(ResultFiles, CsvHasALineForEachMethodAndKindOfPixels) {
  EXPECT_EQ(
      ToCsv(SomeRun()),
      "preset,tof,scene,width,height,method,pixels,correct_le1,correct_lt1,bad05,bad2,bad4,d1,"
      "density,invalid,mean_abs_px,rms_px,refine_ms,prior_ms,grow_ms,fill_ms,total_ms\n"
      "\"paper\",\"grid:auto\",\"Monopoly\",30,20,epc,nonocc,75,70,40,20,15,17.5,90,10,0.5,2,1,2,3,"
      "4,10\n"
      "\"paper\",\"grid:auto\",\"Monopoly\",30,20,epc,all,0,0,100,100,100,100,0,100,,,1,2,3,4,10\n"
      "\"paper\",\"grid:auto\",\"Monopoly\",30,20,epc,away,,,,,,,,,,,1,2,3,4,10\n"
      "\"paper\",\"grid:auto\",\"Monopoly\",30,20,fgs,nonocc,75,70,40,20,15,17.5,90,10,0.5,2,1,2,3,"
      "4,10\n"
      "\"paper\",\"grid:auto\",\"Monopoly\",30,20,fgs,all,0,0,100,100,100,100,0,100,,,1,2,3,4,10\n"
      "\"paper\",\"grid:auto\",\"Monopoly\",30,20,fgs,away,,,,,,,,,,,1,2,3,4,10\n");
}

TEST(Tables, PutThePapersFigureAndTheDifferenceBesideEachCell) {
  EXPECT_THAT(PaperTable(SomeRun().scenes),
              testing::EndsWith("| method | Monopoly | paper |  diff |\n"
                                "|--------|---------:|------:|------:|\n"
                                "| epc    |     75.0 |  85.2 | -10.2 |\n"));
}

TEST(Tables, LeaveOutScenesThatThePaperDoesNotHave) {
  RunResult run = SomeRun();
  run.scenes[0].name = "Baby1";
  EXPECT_EQ(PaperTable(run.scenes), "");
}

TEST(Tables, ShowWhatIsAwayFromThePointsWhereThatIsPartOfTheTruth) {
  SceneResult scene = SomeRun().scenes[0];
  EXPECT_THAT(SceneTable(scene), testing::Not(testing::HasSubstr("away")));
  for (MethodResult& method : scene.methods) method.away = {.scored = 100, .within_1 = 37};
  EXPECT_THAT(SceneTable(scene),
              testing::AllOf(testing::HasSubstr("away <= 1 %"), testing::HasSubstr(" 37.00 |")));
  for (MethodResult& method : scene.methods) method.away.scored = method.all.scored;
  EXPECT_THAT(SceneTable(scene), testing::Not(testing::HasSubstr("away")));
}

TEST(Tables, FitATerminalUnlessAllFiguresAreWanted) {
  const SceneResult scene = SomeRun().scenes[0];
  const auto columns = [](const std::string& table) {
    const std::string head = table.substr(table.find("| method"));
    return std::count(head.begin(), head.begin() + static_cast<long>(head.find('\n')), '|') - 1;
  };
  const auto width = [](const std::string& table) {
    const size_t begin = table.find("| method");
    return table.find('\n', begin) - begin;
  };
  EXPECT_LE(columns(SceneTable(scene)), 10);
  EXPECT_LE(width(SceneTable(scene)), 100U);
  EXPECT_EQ(columns(SceneTable(scene, /*is_wide=*/true)), 18);
  for (const char* figure : {"bad 0.5 %", "rms px", "grow ms", "D1 %"}) {
    EXPECT_THAT(SceneTable(scene, true), testing::HasSubstr(figure));
  }
}

TEST(Tables, SayThatThereAreNoToFPointsInPlaceOfTheirErrors) {
  SceneResult scene = SomeRun().scenes[0];
  scene.refinement = {};
  scene.refinement.refined.seeds = {Seed{}};
  const std::string table = SceneTable(scene);
  EXPECT_THAT(table, testing::HasSubstr("refinement: no ToF points; 1 seeds from stereo, wrong "));
  EXPECT_THAT(table, testing::Not(testing::HasSubstr("nan")));
}

TEST(Tables, ShowEveryMethodOfAScene) {
  const std::string table = SceneTable(SomeRun().scenes[0]);
  EXPECT_THAT(table, testing::HasSubstr("\n| epc    |     75.00 |    70.00 |"));
  EXPECT_THAT(table, testing::HasSubstr("\n| fgs    |     75.00 |    70.00 |"));
  EXPECT_THAT(table,
              testing::HasSubstr("wrong 20.00 % before, 5.00 % after; good ones lost 6.00 %"));
}

cv::Mat3b Filled(cv::Size size, const cv::Vec3b& color) { return cv::Mat3b(size, color); }

const ScaleContent kScale{.axes = {{{0, 4}, "px"}}};

int CountColor(const cv::Mat3b& picture, const cv::Vec3b& color) {
  cv::Mat1b same;
  cv::inRange(picture, color, color, same);
  return cv::countNonZero(same);
}

TEST(Figure, ShowsEveryPictureAtOneWidth) {
  const cv::Vec3b red(0, 0, 255);
  const cv::Vec3b blue(255, 0, 0);
  const cv::Mat3b figure = Figure(
      {"a", "b"}, {{{{Filled({640, 480}, red), "1 %"}, {Filled({640, 480}, blue), ""}}, kScale},
                   {{{Filled({160, 80}, blue), ""}, {Filled({160, 80}, blue), "2 %"}}, kScale}});
  EXPECT_EQ(CountColor(figure, red), 320 * 240);
  EXPECT_EQ(CountColor(figure, blue), 320 * (240 + 2 * 160));
}

TEST(Figure, ExplainsTheColorsOfEachRow) {
  const cv::Mat3b white = Filled({320, 200}, {255, 255, 255});
  const cv::Mat3b figure = Figure({"a"}, {{{{white, ""}}, kScale}, {{{white, ""}}, kScale}});
  EXPECT_GE(CountColor(figure, ColorOf(4, {0, 4})), 2 * 10);
  EXPECT_GE(CountColor(figure, ColorOf(0, {0, 4})), 2 * 10);
}

TEST(Figure, WritesTitlesAndCaptions) {
  const cv::Mat3b white = Filled({320, 200}, {255, 255, 255});
  const cv::Mat3b nothing = Figure({""}, {{{{white, ""}}, kScale}});
  for (const auto& [title, caption] : {std::pair("title", ""), std::pair("", "88.8 %")}) {
    const cv::Mat3b written = Figure({title}, {{{{white, caption}}, kScale}});
    EXPECT_LT(CountColor(written, {255, 255, 255}), CountColor(nothing, {255, 255, 255}) - 100);
  }
}

}  // namespace

}  // namespace sprout::evaluate
