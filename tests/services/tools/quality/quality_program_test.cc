#include <gmock/gmock.h>

#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>

#include "common/core/disparity_image.h"
#include "common/messages/codec.h"
#include "common/picture/write_image.h"
#include "services/tools/quality/program.h"
#include "tests/common/app/run_main.h"
#include "tests/common/logfile/sample_log.h"
#include "tests/common/measure/flat_target.h"

namespace sprout::quality {
namespace {

using sprout::testing::TargetPair;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

MainOutcome RunQuality(std::vector<std::string> words) {
  words.insert(words.begin(), "sprout-quality");
  return RunMain(words, QualityMain);
}

class QualityProgram : public ::testing::Test {
 protected:
  std::string File(const char* name) const { return folder_ / name; }

  std::string WriteText(const char* name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
    return File(name);
  }

  // Maps of the wall with 0.1 px of noise.
  std::vector<cv::Mat1f> Maps(int count, const sprout::testing::FlatTarget& target = {}) const {
    sprout::testing::TargetNoise noise;
    std::vector<cv::Mat1f> maps;
    for (int i = 0; i < count; ++i) maps.push_back(noise.On(target.Disparity(TargetPair()), 0.1));
    return maps;
  }

  // @param sigma  that the maps claim at every pixel, counts; 0: nothing.
  static void Append(const std::vector<cv::Mat1f>& maps, const Rig& rig, bool with_rig,
                     std::vector<Event>& events, int sigma = 0) {
    for (const cv::Mat1f& map : maps) {
      const auto seq = static_cast<int64_t>(events.size());
      const FrameId id{
          .utime = 1'700'000'000'000'000 + 100'000 * seq, .seq = seq, .rig_id = RigId(rig)};
      const auto add = [&](Part part, const PartValue& value) {
        events.push_back({.utime = id.utime,
                          .channel = std::string(ChannelOf(part)),
                          .data = EncodePart(id, part, value)});
      };
      if (with_rig) add(Part::kRig, rig);
      add(Part::kDisparity, FromPx(map));
      if (sigma > 0) add(Part::kSigma, cv::Mat(map.size(), CV_8UC1, cv::Scalar(sigma)));
    }
  }

  std::string WriteLog(const char* name, std::vector<Event> events) const {
    WriteBytes(folder_ / name, MakeLog(events));
    return File(name);
  }

  std::string WriteLog(const char* name, const std::vector<cv::Mat1f>& maps) const {
    std::vector<Event> events;
    Append(maps, {.pair = TargetPair(), .tof = {}}, true, events);
    return WriteLog(name, events);
  }

  std::string WriteFolder(const char* name, const std::vector<cv::Mat1f>& maps) const {
    std::filesystem::create_directory(folder_ / name);
    for (size_t i = 0; i < maps.size(); ++i) {
      const auto path = folder_ / name / (std::to_string(i) + "_disparity.pfm");
      EXPECT_TRUE(WritePfm(path, maps[i]));
    }
    std::ofstream(folder_ / name / "calib.txt")
        << "cam0=[900 0 165; 0 900 115; 0 0 1]\ncam1=[900 0 162; 0 900 115; 0 0 1]\n"
           "baseline=150\nwidth=320\nheight=240\n";
    return File(name);
  }

  nlohmann::json Json() const { return nlohmann::json::parse(FileText(folder_ / "q.json")); }

  // Exit code, nothing on stdout, one line on stderr that holds `reason`, no file.
  void ExpectRefused(std::vector<std::string> arguments, int exit_code,
                     const std::string& reason) const {
    arguments.insert(arguments.end(), {"--json", File("q.json"), "--report", File("q.html")});
    sprout::ExpectRefused(RunQuality(arguments), exit_code, "sprout-quality", reason);
    EXPECT_FALSE(std::filesystem::exists(folder_ / "q.json"));
    EXPECT_FALSE(std::filesystem::exists(folder_ / "q.html"));
  }

  const TemporaryDirectory folder_;
};

TEST_F(QualityProgram, MeasuresALogAndAFolderOfPfmAlike) {
  const std::vector<cv::Mat1f> maps = Maps(4, {.distance_m = 1.5, .horizontal_deg = 3});
  const MainOutcome log = RunQuality({WriteLog("run.lcm", maps), "--distance-m", "1.5"});
  const MainOutcome folder = RunQuality({WriteFolder("maps", maps), "--distance-m", "1.5"});
  EXPECT_EQ(log.exit_code, 0) << log.err;
  EXPECT_EQ(folder.exit_code, 0) << folder.err;
  for (const MainOutcome& outcome : {log, folder}) {
    EXPECT_EQ(outcome.err, "");
    EXPECT_THAT(outcome.out, StartsWith("region 80,60,160,120 of 320x240 px, 4 frames\n"));
    EXPECT_THAT(outcome.out, ContainsRegex("fill rate +100.00 %\n"));
    EXPECT_THAT(outcome.out, ContainsRegex("sub-pixel RMS +0\\.(099|100|101)[0-9] px\n"));
    EXPECT_THAT(outcome.out, ContainsRegex("tilt, left to right +(2.9[5-9]|3.0[0-5]) °\n"));
    EXPECT_THAT(outcome.out, HasSubstr("no sigma claimed: the maps come without a standard "
                                       "deviation (as logs with SPROUT_SIGMA have)\n"));
    EXPECT_THAT(outcome.out, Not(HasSubstr("no Z-accuracy")));
  }
}

TEST_F(QualityProgram, WritesFiguresAndAPage) {
  const MainOutcome outcome =
      RunQuality({WriteLog("run.lcm", Maps(3)), "--region", "20,30,200,100", "--distance-m", "1.6",
                  "--json", File("q.json"), "--report", File("q.html")});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  const nlohmann::json json = Json();
  EXPECT_EQ(json["region"], nlohmann::json({20, 30, 200, 100}));
  EXPECT_EQ(json["frames"], 3);
  EXPECT_EQ(json["true_distance_m"], 1.6);
  EXPECT_EQ(json["good"], nullptr);
  EXPECT_NEAR(json["figures"]["z_accuracy_percent"], 100 * (1.5 - 1.6) / 1.6, 0.05);
  EXPECT_EQ(json["figures"]["sigma_ratio"], nullptr);
  const std::string page = FileText(folder_ / "q.html");
  for (const char* part : {"<h2>Plane</h2>", "<h2>Residuals</h2>", "<h2>Temporal noise</h2>",
                           "<svg", "20,30,200,100", "data:image/png;base64,", "z = 1.500"}) {
    EXPECT_THAT(page, HasSubstr(part));
  }
}

// Noise of 0.1 px; claimed are 2 counts of 1/16 px.
TEST_F(QualityProgram, SaysWhetherTheStandardDeviationsOfALogAreHonest) {
  std::vector<Event> events;
  Append(Maps(3), {.pair = TargetPair(), .tof = {}}, true, events, 2);
  const MainOutcome outcome = RunQuality({WriteLog("run.lcm", events), "--json", File("q.json")});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, Not(HasSubstr("no sigma claimed")));
  EXPECT_DOUBLE_EQ(Json()["figures"]["sigma_claimed_px"], 2 / 16.0);
  EXPECT_NEAR(Json()["figures"]["sigma_ratio"], 1.25, 0.03);
}

TEST_F(QualityProgram, TheSameInputGivesTheSameBytes) {
  const std::string log = WriteLog("run.lcm", Maps(2));
  RunQuality({log, "--json", File("a.json"), "--report", File("a.html")});
  RunQuality({log, "--json", File("b.json"), "--report", File("b.html")});
  EXPECT_EQ(FileText(folder_ / "a.json"), FileText(folder_ / "b.json"));
  EXPECT_EQ(FileText(folder_ / "a.html"), FileText(folder_ / "b.html"));
}

TEST_F(QualityProgram, SaysByItsExitCodeWhetherLimitsAreKept) {
  const std::string log = WriteLog("run.lcm", Maps(3));
  const auto with = [&](const std::string& limits) {
    return RunQuality(
        {log, "--limits", WriteText("limits.textproto", limits), "--json", File("q.json")});
  };
  MainOutcome outcome = with(
      "limit { figure: 'fill_rate_percent' at_least: 100 }\n"
      "limit { figure: 'subpixel_rms_px' at_least: 0.05 at_most: 0.2 }\n");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.out;
  EXPECT_THAT(outcome.out, ContainsRegex("fill rate +100.00 %   good: >= 100\n"));
  EXPECT_THAT(outcome.out, HasSubstr("good: 0.05 to 0.2\n"));
  EXPECT_EQ(Json()["good"], true);

  outcome = with("limit { figure: 'subpixel_rms_px' at_most: 0.05 }");
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.out, HasSubstr("BAD: allowed <= 0.05\n"));
  EXPECT_EQ(Json()["good"], false);
  EXPECT_EQ(Json()["limits"][0]["kept"], false);

  // A figure that was not measured does not keep its limit.
  outcome = with("limit { figure: 'z_accuracy_percent' at_least: -1 at_most: 1 }");
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.out, ContainsRegex("Z-accuracy +-   BAD: allowed -1 to 1\n"));
}

TEST_F(QualityProgram, RefusesLimitsThatCannotBe) {
  const std::string log = WriteLog("run.lcm", Maps(1));
  const auto refused = [&](const std::string& limits, const std::string& reason) {
    ExpectRefused({log, "--limits", WriteText("limits.textproto", limits)}, 2, reason);
  };
  refused("limit { figure: 'fill' at_least: 98 }",
          "no figure is called 'fill'; allowed: fill_rate");
  refused("limit { figure: 'fill_rate_percent' }", "allowed is at_least, at_most or both");
  refused("limit { figure: 'fill_rate_percent' at_least: nan }", "finite numbers");
  refused("limit { figure: 'fill_rate_percent' at_least: 2 at_most: 1 }", "in this order");
  refused("limit { figure: 'distance_m' at_least: 1 } limit { figure: 'distance_m' at_most: 2 }",
          "two limits of distance_m");
  refused("", "no limit in it");
  refused("limits { }", "limits.textproto");
  ExpectRefused({log, "--limits", File("none.textproto")}, 2, "none.textproto");
}

TEST_F(QualityProgram, CountsWhatItLeavesOut) {
  std::vector<Event> events;
  const Rig rig{.pair = TargetPair(), .tof = {}};
  Append(Maps(2), rig, true, events);
  Rig knocked = rig;
  knocked.pair.focal_px += 1;
  Append(Maps(1), knocked, true, events);
  Rig unknown = rig;
  unknown.pair.focal_px += 2;
  Append(Maps(3), unknown, false, events);
  const MainOutcome outcome = RunQuality({WriteLog("run.lcm", events), "--json", File("q.json")});
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_EQ(outcome.err,
            "sprout-quality: left out: 1 maps of another size or calibration than the first, 3 "
            "maps without a calibration\n");
  EXPECT_EQ(Json()["frames"], 2);
  EXPECT_EQ(Json()["maps_of_another_size"], 1);
  EXPECT_EQ(Json()["maps_without_calibration"], 3);
}

TEST_F(QualityProgram, TakesAsManyMapsAsAskedFor) {
  const std::string log = WriteLog("run.lcm", Maps(6));
  RunQuality({log, "--count", "4", "--json", File("q.json")});
  EXPECT_EQ(Json()["frames"], 4);
  // Every map stands behind its calibration: maps have the numbers 0, 2, 4, ...
  RunQuality({log, "--frames", "4:8", "--json", File("q.json")});
  EXPECT_EQ(Json()["frames"], 3);
}

TEST_F(QualityProgram, ATargetWithoutPixelsIsNotGood) {
  const std::vector<cv::Mat1f> maps(2, cv::Mat1f(240, 320, sprout::testing::kNoDisparity));
  const MainOutcome outcome = RunQuality({WriteLog("run.lcm", maps), "--report", File("q.html")});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.out, ContainsRegex("fill rate +0.00 %\n"));
  EXPECT_THAT(outcome.out, HasSubstr("2 without a plane"));
  EXPECT_THAT(outcome.out, HasSubstr("no plane: too few pixels of the region have a disparity\n"));
  EXPECT_THAT(FileText(folder_ / "q.html"), HasSubstr("No plane was found."));
}

TEST_F(QualityProgram, RefusesInputThatCannotBeMeasured) {
  ExpectRefused({WriteText("empty.lcm", "")}, 2, "no frame with SPROUT_DISPARITY");
  ExpectRefused({WriteText("text.lcm", "no log at all, but long enough to be one")}, 2, "text.lcm");
  ExpectRefused({File("none.lcm")}, 2, "none.lcm");
  std::vector<Event> events;
  Append(Maps(2), {.pair = TargetPair(), .tof = {}}, false, events);
  ExpectRefused({WriteLog("norig.lcm", events)}, 2, "no calibration (SPROUT_RIG)");
  for (Event& event : events) event.channel = "B_" + event.channel;
  ExpectRefused({WriteLog("other.lcm", events)}, 2, "see --channel-prefix");
  const std::string log = WriteLog("run.lcm", Maps(1));
  ExpectRefused({log, "--region", "200,0,200,100"}, 2,
                "region 200,0,200,100: allowed is a rectangle LEFT,TOP,WIDTH,HEIGHT");
  for (const char* text : {"1,2,3", "1,2,3,4,5", "1,2,3,x", "", "1,2,,4", "1.5,2,30,40"}) {
    ExpectRefused({log, "--region", text}, 2, "--region");
  }
  ExpectRefused({log, "--edge", "0,0,4,100"}, 2, "edge 0,0,4,100: allowed");
  ExpectRefused({log, "--distance-m", "0"}, 2, "--distance-m");
  ExpectRefused({log, "--count", "0"}, 2, "--count");
  ExpectRefused({log, "--frames", "9:1"}, 2, "--frames");
}

// As `sprout-pipeline files` leaves them of many pairs.
TEST_F(QualityProgram, MeasuresMapsOneLevelDownWithTheirOwnCalibration) {
  const std::string flat = WriteFolder("flat", Maps(3));
  for (const std::string name : {"0", "1", "2"}) {
    const std::filesystem::path pair = File("out") + "/pair" + name;
    std::filesystem::create_directories(pair);
    std::filesystem::copy_file(flat + "/" + name + "_disparity.pfm", pair / "disparity.pfm");
    std::filesystem::copy_file(folder_ / "flat/calib.txt", pair / "calib.txt");
  }
  const MainOutcome of_flat = RunQuality({flat});
  const MainOutcome of_nested = RunQuality({File("out")});
  EXPECT_EQ(of_nested.exit_code, 0) << of_nested.err;
  EXPECT_THAT(of_nested.out, HasSubstr(" 3 frames\n"));
  EXPECT_EQ(of_nested.out, of_flat.out);
}

TEST_F(QualityProgram, RefusesFoldersThatCannotBeMeasured) {
  std::filesystem::create_directory(folder_ / "empty");
  ExpectRefused({File("empty")}, 2, "no map of disparities (*.pfm) in it");
  for (const std::string name : {"depth", "depth_sigma"}) {
    EXPECT_TRUE(WritePfm(File("empty") + "/" + name + ".pfm", cv::Mat1f(240, 320, 2.0F)));
  }
  ExpectRefused({File("empty")}, 2, "no map of disparities (*.pfm) in it");
  const std::string maps = WriteFolder("maps", Maps(1));
  std::ofstream(folder_ / "maps/1_disparity.pfm") << "Pf\n320 240\n-1\n too short";
  ExpectRefused({maps}, 2, "1_disparity.pfm: ends early");
  std::filesystem::remove(folder_ / "maps/1_disparity.pfm");
  ExpectRefused({maps, "--calib", File("none.txt")}, 2, "none.txt");
  std::filesystem::remove(folder_ / "maps/calib.txt");
  ExpectRefused({maps}, 2, "calib.txt");
}

TEST_F(QualityProgram, ReplacesNothingThatItReads) {
  const std::string folder = WriteFolder("maps", Maps(2));
  const std::string calibration = FileText(folder + "/calib.txt");
  for (const std::string name : {"calib.txt", "0_disparity.pfm"}) {
    const MainOutcome outcome = RunQuality({folder, "--report", folder + "/" + name});
    EXPECT_EQ(outcome.exit_code, 2) << name;
    EXPECT_THAT(outcome.err, HasSubstr("--report " + folder + "/" + name)) << name;
    EXPECT_THAT(outcome.err, HasSubstr("an input of this run")) << name;
  }
  EXPECT_EQ(FileText(folder + "/calib.txt"), calibration);
  const std::string log = WriteLog("run.lcm", Maps(2));
  EXPECT_EQ(RunQuality({log, "--json", log}).exit_code, 2);
  EXPECT_EQ(RunQuality({folder, "--report", folder + "/report.html"}).exit_code, 0);
  EXPECT_EQ(RunQuality({folder, "--report", folder + "/report.html"}).exit_code, 0);  // again
}

TEST_F(QualityProgram, WritesNoTwoResultsToOneFile) {
  const std::string log = WriteLog("run.lcm", Maps(1));
  for (const std::string& same : {File("q.json"), File("./q.json")}) {
    const MainOutcome outcome = RunQuality({log, "--json", File("q.json"), "--report", same});
    EXPECT_EQ(outcome.exit_code, 2);
    EXPECT_THAT(outcome.err, HasSubstr("--report " + same + ": cannot be written (--json writes"));
    EXPECT_FALSE(std::filesystem::exists(folder_ / "q.json"));
  }
  EXPECT_EQ(RunQuality({log, "--json", "/dev/null", "--report", "/dev/null"}).exit_code, 0);
}

// A ridge: two planes, as of a corner of a room.
TEST_F(QualityProgram, TakesNoCornerForAPlane) {
  cv::Mat1f map(240, 320);
  for (int u = 0; u < map.cols; ++u) {
    map.col(u).setTo(80 + 0.1 * std::abs(u - map.cols / 2));
  }
  const MainOutcome outcome = RunQuality({WriteLog("run.lcm", std::vector<cv::Mat1f>{map})});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.out, HasSubstr("\nno plane: pixels lie "));
}

TEST_F(QualityProgram, SaysThatNoEdgeCrossesTheEdge) {
  const MainOutcome outcome = RunQuality({WriteLog("run.lcm", Maps(1)), "--edge", "20,20,60,60"});
  EXPECT_THAT(outcome.out, HasSubstr("no edge width: no step of 1 px or more in --edge\n"));
  EXPECT_THAT(outcome.out, HasSubstr("no temporal noise: it takes at least two frames\n"));
}

TEST_F(QualityProgram, OfAFolderTakesTheDisparitiesAlone) {
  const std::string maps = WriteFolder("maps", Maps(2));
  EXPECT_TRUE(WritePfm(folder_ / "maps/0_prior.pfm", cv::Mat1f(240, 320, 5.0F)));
  EXPECT_THAT(RunQuality({maps}).out, HasSubstr("2 frames\n"));
}

TEST_F(QualityProgram, RefusesABusThatCannotBe) {
  ExpectRefused({"--lcm-url", "udp://here"}, 2, "--lcm-url");
  ExpectRefused({"--channel-prefix", "a b"}, 2, "--channel-prefix");
}

}  // namespace
}  // namespace sprout::quality
