#include "services/tools/evaluate/program.h"

#include <gmock/gmock.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "common/config/config.h"
#include "tests/common/app/run_main.h"
#include "tests/common/scenes/kitti_folder.h"
#include "tests/common/scenes/scene_folder.h"
#include "tests/common/testing/test_with_folder.h"

namespace sprout::evaluate {
namespace {

using testing::HasSubstr;

// A log of three frames of kScene: frame 1 has the truth, frame 2 is 2 px off, frame 3 was not
// answered. Those of other.lcm show something else.
void ReadSyntheticLog(const LogChoice& log, const std::function<void(const Frame&)>& visit) {
  const bool other = log.file == "other.lcm";
  if (!other && log.file != "run.lcm") throw ConfigError(log.file + ": no such log");
  const auto source = scenes::OpenDataset("synthetic:96x72");
  for (const int64_t seq : {1, 2, 3}) {
    const scenes::DatasetFrame captured = source->Get(seq);
    Frame frame;
    frame.id = {.utime = 1000 * seq, .seq = seq, .rig_id = "rig"};
    frame.left = other ? source->Get(seq + 5).left : captured.left;
    frame.right = captured.right;
    cv::Mat1f map_px = captured.truth.left.clone();
    if (seq == 2) map_px += 2;
    if (seq < 3) frame.disparity = FromPx(map_px);
    visit(frame);
  }
}

// Command `scenes`, unless another one is named.
MainOutcome Evaluate(std::vector<std::string> words) {
  if (words.empty() || (words[0] != "log" && words[0] != "video" && words[0] != "--help")) {
    words.insert(words.begin(), "scenes");
  }
  words.insert(words.begin(), "sprout-evaluate");
  return RunMain(words, [](int argc, const char* const* argv) {
    return EvaluateMain(argc, argv, ReadSyntheticLog);
  });
}

const char* const kScene = "synthetic:96x72";

nlohmann::json WithoutTimes(const std::filesystem::path& path) {
  nlohmann::json json = nlohmann::json::parse(FileText(path));
  for (auto& scene : json["scenes"]) {
    for (auto& method : scene["methods"]) method.erase("ms");
  }
  return json;
}

void ExpectRefused(const std::vector<std::string>& arguments, const std::string& reason) {
  ExpectRefused(Evaluate(arguments), 2, "sprout-evaluate", reason);
}

class EvaluateProgram : public TestWithFolder {};

TEST_F(EvaluateProgram, PrintsTablesAndNoProgressIntoAPipe) {
  const MainOutcome outcome = Evaluate({kScene, "--methods", "prior,fgs", "--tof", "grid:4"});
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_THAT(outcome.out, HasSubstr("| prior  |"));
  EXPECT_THAT(outcome.out, HasSubstr("| fgs    |"));
  EXPECT_EQ(outcome.err, "");
}

TEST_F(EvaluateProgram, SaysNothingWhenQuiet) {
  const MainOutcome outcome = Evaluate({kScene, "--methods", "prior", "--quiet"});
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_EQ(outcome.out + outcome.err, "");
}

TEST_F(EvaluateProgram, TeachesItsDefinitions) {
  const MainOutcome outcome = Evaluate({"--help"});
  EXPECT_EQ(outcome.exit_code, 0);
  for (const char* text : {"bad N", "nonocc", "<= 1, < 1", "wrong seed"}) {
    EXPECT_THAT(outcome.out, HasSubstr(text));
  }
  EXPECT_THAT(Evaluate({kScene, "--help"}).out, HasSubstr("sgbm-5way"));
}

TEST_F(EvaluateProgram, WritesTheSameJsonEveryTimeButForTheTimes) {
  const std::vector<std::string> flags = {kScene, "--methods",        "all", "--seed-noise-px",
                                          "1",    "--seed-jitter-px", "1",   "--quiet"};
  const auto run = [&](const char* name, const std::vector<std::string>& more) {
    std::vector<std::string> arguments = flags;
    arguments.insert(arguments.end(), more.begin(), more.end());
    arguments.insert(arguments.end(), {"--json", folder_ / name});
    ASSERT_EQ(Evaluate(arguments).exit_code, 0);
  };
  run("a.json", {"--seed", "3"});
  run("b.json", {"--seed", "3", "--threads", "2", "--repeat", "2"});
  run("c.json", {"--seed", "4"});
  EXPECT_EQ(WithoutTimes(folder_ / "a.json").dump(), WithoutTimes(folder_ / "b.json").dump());
  EXPECT_NE(WithoutTimes(folder_ / "a.json").dump(), WithoutTimes(folder_ / "c.json").dump());
  EXPECT_EQ(folder_.CountEntries(), 3) << "files and nothing beside them";
}

TEST_F(EvaluateProgram, NamesTheConfigurationInTheResults) {
  std::ofstream(folder_ / "mine.textproto") << "grow { sigma_p_px: 2 }\n";
  ASSERT_EQ(Evaluate({kScene, "--methods", "prior", "--preset", "paper", "--config",
                      folder_ / "mine.textproto", "--json", folder_ / "a.json", "--quiet"})
                .exit_code,
            0);
  EXPECT_EQ(WithoutTimes(folder_ / "a.json")["preset"], "paper+mine");
}

void WriteOnePictureTwice(const scenes::SceneFolder& scene) {
  scene.Write2005({160, 120});
  cv::Mat1b noise(120, 160);
  cv::randu(noise, 0, 256);
  for (const char* name : {"view1.png", "view5.png"}) scene.WriteImage(name, noise);
}

TEST_F(EvaluateProgram, EndsWithOneWhereLeftAndRightAreTheSamePicture) {
  const scenes::SceneFolder scene;
  WriteOnePictureTwice(scene);
  const MainOutcome outcome =
      Evaluate({scene.File("."), "--methods", "prior", "--json", folder_ / "a.json"});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.err, HasSubstr("left and right are the same picture"));
  EXPECT_EQ(folder_.CountEntries(), 1);
}

TEST_F(EvaluateProgram, EndsWithOneWhereAVideoIsWrong) {
  const scenes::SceneFolder scene;
  WriteOnePictureTwice(scene);
  const MainOutcome outcome = Evaluate({"video", "middlebury:" + scene.File("."), "--frames", "3"});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.err, HasSubstr("left and right are the same picture"));
}

TEST_F(EvaluateProgram, WritesAPictureOfEveryMapAndAFigure) {
  ASSERT_EQ(Evaluate({"synthetic:96x72", "synthetic:80x64", "--methods", "prior,fgs", "--images",
                      folder_ / "new" / "pictures", "--quiet"})
                .exit_code,
            0);
  const auto pictures = folder_ / "new" / "pictures";
  for (const char* name : {"synthetic:96x72_prior.png", "synthetic:80x64_fgs.png"}) {
    EXPECT_FALSE(cv::imread(pictures / name).empty()) << name;
  }
  const cv::Mat figure = cv::imread(pictures / "figure.png");
  EXPECT_GT(figure.cols, 4 * 320);  // left image, two maps, truth
  EXPECT_GT(figure.rows, 240 + 256);
}

TEST_F(EvaluateProgram, RefusesUnknownMethodsPresetsAndTofCameras) {
  ExpectRefused({kScene, "--methods", "prior,elas"}, "--methods elas: no such method");
  ExpectRefused({kScene, "--preset", "turbo"}, "allowed: a file, or a preset");
  ExpectRefused({kScene, "--tof", "lidar"}, "--tof lidar");
  ExpectRefused({kScene, "--seed-noise-px", "nan"}, "--seed-noise-px: 'nan' is not allowed");
  ExpectRefused({kScene, "--seed-jitter-px", "nan"}, "--seed-jitter-px: 'nan' is not allowed");
  ExpectRefused({kScene, "--repeat", "0"}, "--repeat");
  ExpectRefused({kScene, "--seed-noise-px", "-1"}, "--seed-noise-px");
  ExpectRefused({}, "SCENE");
}

TEST_F(EvaluateProgram, RefusesToSimulateATofCameraBesideAScanAndTheOtherWayRound) {
  const scenes::KittiFolder kitti("000007");
  const std::string frame = kitti.Config("/000007").source();
  ExpectRefused({frame, "--tof", "sr4000"}, "has a scan of its own; allowed: scan, none");
  ExpectRefused({kScene, "--tof", "scan"}, "has no scan");
  ExpectRefused({kScene, frame}, "has a scan of its own");
  kitti.WriteObject("000008");
  ExpectRefused({kitti.Config("/000008").source()}, "no ground truth");
}

TEST_F(EvaluateProgram, TakesAllFramesOfAKittiFolder) {
  const scenes::KittiFolder kitti("000007");
  kitti.WriteStereo("000014");
  ASSERT_EQ(Evaluate({kitti.Config("?beams=16").source(), "--methods", "sgbm-3way", "--json",
                      folder_ / "a.json", "--images", folder_ / "pictures", "--quiet"})
                .exit_code,
            0);
  const nlohmann::json json = WithoutTimes(folder_ / "a.json");
  EXPECT_EQ(json["tof"], "scan");
  ASSERT_EQ(json["scenes"].size(), 2u);
  EXPECT_EQ(json["scenes"][0]["name"], "000007_beams=16");
  EXPECT_EQ(json["scenes"][1]["name"], "000014_beams=16");
}

TEST_F(EvaluateProgram, RunsWithoutATofCamera) {
  const scenes::KittiFolder kitti("000007");
  const scenes::SceneFolder middlebury(cv::Size(40, 30));
  for (const std::string& scene :
       {std::string(kScene), middlebury.File("."), kitti.Config("/000007").source()}) {
    const MainOutcome outcome =
        Evaluate({scene, "--tof", "none", "--methods", "sprout,sgbm-3way,fgs", "--json",
                  folder_ / "a.json", "--images", folder_ / "pictures"});
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    const nlohmann::json json = WithoutTimes(folder_ / "a.json");
    EXPECT_EQ(json["tof"], "none");
    EXPECT_EQ(json["scenes"][0]["refinement"]["raw"], 0);
  }
}

TEST_F(EvaluateProgram, RefusesAFolderWithoutGroundTruth) {
  const scenes::SceneFolder scene(cv::Size(40, 30));
  scene.Remove("disp1.png");
  ExpectRefused({scene.File("").c_str(), "--json", folder_ / "a.json", "--images", folder_ / "new"},
                "disp1 is missing");
  EXPECT_EQ(folder_.CountEntries(), 0);
}

TEST_F(EvaluateProgram, RefusesImagesAndTruthsOfDifferentSizes) {
  for (const char* name : {"view5.png", "disp1.png", "disp5.png"}) {
    const scenes::SceneFolder scene(cv::Size(40, 30));
    scene.WriteImage(name, cv::Mat1b(31, 40, uchar{40}));
    // A good scene before it is not run either.
    ExpectRefused({kScene, scene.File("."), "--json", folder_ / "a.json"}, "40x31");
  }
  EXPECT_EQ(folder_.CountEntries(), 0);
}

TEST_F(EvaluateProgram, RefusesImagesWiderThanAnyStageTakes) {
  const scenes::SceneFolder scene(cv::Size(16385, 3));
  ExpectRefused({scene.File(".")}, "16385x3 px; allowed: 1 to 16384 px a side");
}

TEST_F(EvaluateProgram, RefusesOutputsThatCannotBeWritten) {
  std::ofstream(folder_ / "file") << "kept";
  ExpectRefused({kScene, "--json", folder_ / "missing" / "a.json"}, "--json");
  ExpectRefused({kScene, "--csv", folder_ / "missing" / "a.csv"}, "--csv");
  ExpectRefused({kScene, "--json", folder_ / ""}, "--json");
  ExpectRefused({kScene, "--images", folder_ / "file"}, "--images");
  std::filesystem::create_symlink("file", folder_ / "link");
  ExpectRefused({kScene, "--json", folder_ / "link"}, "a symbolic link");
  std::ofstream(folder_ / "new.json.part") << "somebody else's";
  ExpectRefused({kScene, "--json", folder_ / "new.json", "--csv", folder_ / "link"}, "--csv");
  EXPECT_EQ(folder_.CountEntries(), 3);
  EXPECT_EQ(FileText(folder_ / "file"), "kept");
  EXPECT_EQ(FileText(folder_ / "new.json.part"), "somebody else's");
}

TEST_F(EvaluateProgram, KeepsAnOlderFileWhenTheRunIsRefused) {
  std::ofstream(folder_ / "a.json") << "older";
  ExpectRefused({kScene, "--json", folder_ / "a.json", "--csv", folder_ / "missing" / "a.csv"},
                "--csv");
  EXPECT_EQ(FileText(folder_ / "a.json"), "older");
  EXPECT_EQ(folder_.CountEntries(), 1);
}

TEST_F(EvaluateProgram, RefusesPicturesOfTwoScenesOfOneName) {
  ExpectRefused({kScene, kScene, "--images", folder_ / "new"}, "two scenes have the name");
  EXPECT_EQ(folder_.CountEntries(), 0);
}

TEST_F(EvaluateProgram, ScoresTheAnswersOfALogAgainstTheTruthOfItsSource) {
  const auto json_file = folder_ / "log.json";
  const MainOutcome outcome = Evaluate(
      {"log", "run.lcm", "--truth", kScene, "--json", json_file, "--csv", folder_ / "log.csv"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("3 frames, 2 with a disparity map, 2 with ground truth"));
  EXPECT_THAT(outcome.out, HasSubstr("\n| disparity |"));
  const auto frames = nlohmann::json::parse(FileText(json_file))["frames"];
  ASSERT_EQ(frames.size(), 3U);
  EXPECT_EQ(frames[0]["maps"]["disparity"]["correct_le1"], 100);
  EXPECT_EQ(frames[1]["maps"]["disparity"]["correct_le1"], 0);
  EXPECT_NEAR(frames[1]["maps"]["disparity"]["mean_abs_px"], 2, 0.02);
  EXPECT_GT(frames[0]["score"], frames[1]["score"]);
  EXPECT_TRUE(frames[2]["score"].is_null());
  EXPECT_THAT(FileText(folder_ / "log.csv"), testing::StartsWith("seq,utime,score,valid_share,"));
}

TEST_F(EvaluateProgram, JudgesALogWithoutTruthByItsQuality) {
  const MainOutcome outcome = Evaluate({"log", "run.lcm"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("3 frames, 2 with a disparity map, 0 with ground truth"));
  EXPECT_THAT(outcome.out, HasSubstr("| misfit "));
  EXPECT_THAT(outcome.out, testing::Not(HasSubstr("<= 1 px")));
}

TEST_F(EvaluateProgram, RefusesWhatDoesNotGoWithALog) {
  ExpectRefused({"log", "gone.lcm"}, "gone.lcm: no such log");
  ExpectRefused({"log", "run.lcm", "--truth", "synthetic:48x36"}, "--truth: frame 1, score: ");
  ExpectRefused({"log", "other.lcm", "--truth", kScene}, "frame 1 of the log is another picture");
  ExpectRefused({"log", "run.lcm", kScene}, kScene);
  ExpectRefused({"log", "run.lcm", "--images", "x"}, "--images");
  ExpectRefused({kScene, "--truth", kScene}, "--truth");
}

}  // namespace
}  // namespace sprout::evaluate
