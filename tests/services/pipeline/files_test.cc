#include "services/pipeline/files/files.h"

#include <gmock/gmock.h>
#include <sys/resource.h>

#include <cmath>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <limits>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <set>

#include "common/core/read_text.h"
#include "common/geometry/projection.h"
#include "common/rig/rectifier.h"
#include "common/rig/rig_file.h"
#include "common/scenes/dataset.h"
#include "common/scenes/middlebury_calibration.h"
#include "common/scenes/pfm.h"
#include "services/pipeline/pipeline.h"
#include "tests/common/testing/thrown.h"
#include "tests/services/pipeline/files_fixture.h"

namespace sprout {
namespace {

namespace fs = std::filesystem;

using testing::HasSubstr;
using testing::StartsWith;

constexpr double kInf = std::numeric_limits<double>::infinity();

TEST_F(Files, HoldWhatThePipelineComputesOfAPairAndADepthImage) {
  const DepthFrame expected = Expected(tof_, RigOfFlags());
  ASSERT_GT(expected.disparity.CountValid(), 0.9 * pair_.size().area());
  for (const char* tof : {"tof.pfm", "tof.png"}) {
    options_.tof = folder_ / tof;
    const MainOutcome outcome = RunToEnd(options_);
    EXPECT_EQ(outcome.exit_code, 0) << tof;
    EXPECT_THAT(outcome.err, testing::IsEmpty()) << tof;
    EXPECT_THAT(outcome.out, HasSubstr("/out: 160x120, " +
                                       std::to_string(expected.seeds.seeds.size()) + " seeds, "));
    ExpectResults(expected, pair_);
  }
}

TEST_F(Files, NeedNoToFImage) {
  EXPECT_EQ(RunToEnd(options_).exit_code, 0);
  ExpectResults(Expected({}, RigOfFlags()), pair_);
}

TEST_F(Files, OfUnrectifiedCamerasAreRectifiedByTheRigFile) {
  RawRig raw;
  raw.left = {.width = 160, .height = 120, .fx = 150, .fy = 150, .cx = 79, .cy = 60};
  raw.left.distortion = {-0.1, 0, 0, 0, 0};
  raw.right = raw.left;
  raw.left_from_right.translation_m = Eigen::Vector3d(0.1, 0, 0);
  RigDescription description;
  *description.mutable_calibration() = ToCalibration(raw);
  const std::string rig_file = folder_ / "rig.textproto";
  ASSERT_TRUE(SaveRigFile(rig_file, description));
  options_.rig = {.rig_file = rig_file};
  EXPECT_EQ(RunToEnd(options_).exit_code, 0);
  const Rectifier rectifier(raw);
  ExpectResults(Pipeline(LoadConfig({"default"}))
                    .Compute(rectifier.RectifyLeft(scene_.left),
                             rectifier.RectifyRight(scene_.right), {}, rectifier.rig())
                    .value(),
                rectifier.rig().pair);

  const cv::Mat small(60, 80, CV_8UC1, cv::Scalar(0));
  options_.left = Write("small.png", small);
  EXPECT_THAT(RunToEnd(options_).err, HasSubstr("small.png: left image of 80x60: allowed is the "
                                                "calibrated size 160x120\n"));
  options_.left = folder_ / "left.png";
  options_.tof = folder_ / "tof.png";
  EXPECT_THAT(RunToEnd(options_).err,
              HasSubstr("left.png: ToF image of 40x30: allowed is none, the "
                        "calibration has none\n"));
}

TEST_F(Files, OfManyPairsAreComputedButForTheOnesThatCannotBe) {
  for (const char* name : {"l/b.png", "l/a.png", "l/c.png"}) Write(name, scene_.left);
  for (const char* name : {"r/1.png", "r/3.png"}) Write(name, scene_.right);
  Write("r/2.png", cv::Mat(60, 80, CV_8UC1, cv::Scalar(0)));
  std::ofstream(folder_ / "l" / "notes.txt") << "no image\n";
  options_.left = folder_ / "l";
  options_.right = folder_ / "r/?.png";
  const MainOutcome outcome = RunToEnd(options_);
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.err,
              HasSubstr("l/b.png: right: 80x60; allowed: the calibrated size 160x120"));
  EXPECT_THAT(outcome.err, HasSubstr("LEFT and RIGHT belong together in the order of their names"));
  EXPECT_THAT(outcome.err, HasSubstr("1 of 3 pairs left out\n"));
  EXPECT_THAT(outcome.out, HasSubstr("out/a: 160x120"));
  EXPECT_THAT(outcome.out, HasSubstr("out/c: 160x120"));
  EXPECT_TRUE(fs::exists(folder_ / "out" / "a" / "disparity.pfm"));
  EXPECT_FALSE(fs::exists(folder_ / "out" / "b"));
  EXPECT_TRUE(SameBytes(cv::imread(folder_ / "out" / "a" / "disparity.png", cv::IMREAD_UNCHANGED),
                        cv::imread(folder_ / "out" / "c" / "disparity.png", cv::IMREAD_UNCHANGED)));
}

TEST_F(Files, OfOneNameInSeveralFoldersGoToFoldersOfTheirOwn) {
  for (const char* name : {"x/im0.png", "y/im0.png"}) Write(name, scene_.left);
  for (const char* name : {"x/im1.png", "y/im1.png"}) Write(name, scene_.right);
  options_.left = folder_ / "*/im0.png";
  options_.right = folder_ / "*/im1.png";
  EXPECT_EQ(RunToEnd(options_).exit_code, 0);
  EXPECT_TRUE(fs::exists(folder_ / "out" / "x_im0" / "depth.pfm"));
  EXPECT_TRUE(fs::exists(folder_ / "out" / "y_im0" / "depth.pfm"));
}

TEST_F(Files, OfAVideoAreFusedWhenAsked) {
  const auto dataset = scenes::OpenDataset("synthetic:160x120");
  const std::vector<std::string> configs = {"default", "temporal { in_pipeline: true }",
                                            "depth { input: FUSED }"};
  Pipeline pipeline(LoadConfig(configs));
  std::vector<DepthFrame> expected;
  Rig rig = RigOfFlags();
  rig.tof = TofCamera();
  for (int i = 0; i < 3; ++i) {
    const scenes::DatasetFrame frame = dataset->Get(i);
    const std::string name = "/" + std::to_string(i) + ",.png";
    Write(("l" + name).c_str(), frame.left);
    Write(("r" + name).c_str(), frame.right);
    expected.push_back(pipeline.Compute(frame.left, frame.right, {}, rig).value());
  }
  options_.left = folder_ / "l";
  options_.right = folder_ / "r";
  EXPECT_EQ(RunFiles(options_, LoadConfig(configs), {}), 0);
  const auto motion = ReadText(folder_ / "out" / "motion.csv", 10000).value();
  EXPECT_THAT(motion, StartsWith("left,reset,resets,tracked,inliers,x_m,y_m,z_m,qw,qx,qy,qz\n"
                                 "\"0,.png\",FIRST,0,0,0,0,0,0,1,0,0,0\n"
                                 "\"1,.png\",NONE,0,"));
  EXPECT_EQ(std::ranges::count(motion, '\n'), 4);
  for (int i = 0; i < 3; ++i) {
    const fs::path out = folder_ / "out" / (std::to_string(i) + ",");
    const DepthFrame& frame = expected[static_cast<size_t>(i)];
    EXPECT_TRUE(SameBytes(scenes::ReadPfm(out / "depth.pfm"), frame.depth_m));
    EXPECT_TRUE(SameBytes(cv::imread(out / "fused_confidence.png", cv::IMREAD_UNCHANGED),
                          frame.fused_confidence));
    EXPECT_TRUE(fs::exists(out / "fused.pfm"));
    const cv::Mat fused = cv::imread(out / "fused.png", cv::IMREAD_UNCHANGED);
    const cv::Mat single = cv::imread(out / "disparity.png", cv::IMREAD_UNCHANGED);
    EXPECT_EQ(cv::countNonZero(fused), frame.fused.CountValid());
    EXPECT_EQ(SameBytes(fused, single), i == 0);
  }
}

// What a pair that does not fit its calibration gives is not fused into those behind it.
TEST_F(Files, OfAPairThatDoesNotFitAreForgotten) {
  cv::Mat lower;
  cv::warpAffine(scene_.right, lower, cv::Matx23d(1, 0, 0, 0, 1, 6), scene_.right.size());
  for (const int i : {0, 1, 2}) {
    const std::string name = "/" + std::to_string(i) + ".png";
    Write(("l" + name).c_str(), i == 1 ? cv::Mat(scene_.left + cv::Scalar::all(1)) : scene_.left);
    Write(("r" + name).c_str(), i == 1 ? lower : scene_.right);
  }
  options_.left = folder_ / "l";
  options_.right = folder_ / "r";
  const MainOutcome ended = RunToEnd(options_, {}, {"default", "temporal { in_pipeline: true }"});
  EXPECT_THAT(ended.err, HasSubstr("rows"));
  const auto of = [&](const char* pair, const char* name) {
    return cv::imread(folder_ / "out" / pair / name, cv::IMREAD_UNCHANGED);
  };
  EXPECT_TRUE(SameBytes(of("2", "fused.png"), of("0", "fused.png")));
  EXPECT_TRUE(SameBytes(of("2", "fused_confidence.png"), of("0", "confidence.png")));
}

TEST_F(Files, OfACameraThatHangsAreNotBelieved) {
  for (const int i : {0, 1}) {
    const std::string name = "/" + std::to_string(i) + ".png";
    Write(("l" + name).c_str(), scene_.left);
    const cv::Rect part(i * 5, 0, scene_.right.cols - 5, scene_.right.rows);
    cv::Mat turned;
    cv::resize(scene_.right(part), turned, scene_.right.size());
    Write(("r" + name).c_str(), turned);
  }
  options_.left = folder_ / "l";
  options_.right = folder_ / "r";
  EXPECT_THAT(RunToEnd(options_).err,
              HasSubstr("1.png: the left image is that of the pair before"));
  const auto confidence = cv::imread(folder_ / "out/1/confidence.png", cv::IMREAD_UNCHANGED);
  EXPECT_EQ(cv::countNonZero(confidence), 0);
}

TEST_F(Files, LeaveOutOfDepthsAndPointsWhatTheDepthSettingsSay) {
  const DepthFrame all = Expected({}, RigOfFlags());
  double near_m = 0;
  double far_m = 0;
  cv::minMaxIdx(all.depth_m, &near_m, &far_m, nullptr, nullptr, all.depth_m == all.depth_m);
  const double middle_m = (near_m + far_m) / 2;
  const auto is_kept_by = [&](const std::string& rule, cv::Point p) {
    const double z = double{all.depth_m(p)};
    if (rule == "max_m") return z <= middle_m;
    if (rule == "min_m") return z >= middle_m;
    if (rule == "region") return p.x >= 20 && p.x <= 99 && p.y >= 10 && p.y <= 60;
    return all.confidence(p) >= 204;
  };
  const std::pair<std::string, std::string> settings[] = {
      {"max_m", "max_m: " + std::to_string(middle_m)},
      {"min_m", "min_m: " + std::to_string(middle_m)},
      {"region", "region: [20, 10, 99, 60]"},
      {"min_confidence", "min_confidence: 204"}};
  for (const auto& [rule, setting] : settings) {
    EXPECT_EQ(RunFiles(options_, LoadConfig({"default", "depth { " + setting + " }"}), {}), 0);
    const cv::Mat1f depth_m = scenes::ReadPfm(folder_ / "out" / "depth.pfm");
    const cv::Mat1f sigma_m = scenes::ReadPfm(folder_ / "out" / "depth_sigma.pfm");
    int kept = 0;
    int wrong = 0;
    for (int v = 0; v < depth_m.rows; ++v) {
      for (int u = 0; u < depth_m.cols; ++u) {
        const bool expected = std::isfinite(all.depth_m(v, u)) && is_kept_by(rule, {u, v});
        kept += expected ? 1 : 0;
        if (std::isfinite(depth_m(v, u)) != expected) ++wrong;
        if (std::isnan(sigma_m(v, u)) == expected) ++wrong;
      }
    }
    EXPECT_EQ(wrong, 0) << rule;
    EXPECT_GT(kept, 0) << rule;
    EXPECT_LT(kept, all.disparity.CountValid()) << rule;
    for (const char* name : {"cloud.ply", "mesh.ply"}) {
      const std::string text = ReadText(folder_ / "out" / name, 10'000'000).value();
      EXPECT_THAT(text.substr(0, 1000), HasSubstr("element vertex " + std::to_string(kept) + "\n"));
    }
    // What growth says is not changed.
    const cv::Mat1f px = scenes::ReadPfm(folder_ / "out" / "disparity.pfm");
    EXPECT_EQ(cv::countNonZero(px < kInf), all.disparity.CountValid());
  }
}

TEST_F(Files, HaveTheCalibrationBesideThem) {
  EXPECT_EQ(RunToEnd(options_).exit_code, 0);
  const RectifiedPair pair =
      scenes::CalibrationFromCalib(folder_ / "out" / "calib.txt", pair_.size());
  EXPECT_EQ(pair.focal_px, pair_.focal_px);
  EXPECT_EQ(pair.cx, pair_.cx);
  EXPECT_EQ(pair.cx_right, pair_.cx_right);
  EXPECT_NEAR(pair.baseline_m, pair_.baseline_m, 1e-12);
}

TEST_F(Files, RefuseDepthSettingsThatTheyDoNotApply) {
  const std::pair<std::string, std::string> table[] = {
      {"every: 2", "depth.every: "},
      {"mm_per_count: 0.5", "depth.mm_per_count: "},
      {"scale: 2", "depth.scale: "},
      {"cloud_stride: 2", "depth.cloud_stride: "},
      {"cloud_voxel_m: 0.1", "depth.cloud_voxel_m: "},
      {"publish_scan: true", "depth.publish_scan: "},
      {"target: 'thermal'", "depth.target: "},
      {"box { max_z_m: 2 }", "depth.box: "},
      {"min_m: 3 max_m: 2", "depth.min_m"}};
  for (const auto& [setting, text] : table) {
    EXPECT_THAT(Thrown<ConfigError>([&] {
                  RunFiles(options_, LoadConfig({"default", "depth { " + setting + " }"}), {});
                }),
                StartsWith(text));
  }
  EXPECT_THROW(RunFiles(options_, LoadConfig({"fast", "depth { min_confidence: 9 }"}), {}),
               ConfigError);
  EXPECT_FALSE(fs::exists(folder_ / "out"));
}

TEST_F(Files, AreOnlyThoseThatAreAskedFor) {
  options_.only = {"depth", "cloud"};
  EXPECT_EQ(RunToEnd(options_).exit_code, 0);
  std::set<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder_ / "out")) {
    names.insert(entry.path().filename());
  }
  EXPECT_THAT(names, testing::ElementsAre("calib.txt", "camera.json", "cloud.ply", "depth.pfm",
                                          "depth.png"));
}

// Beside new results they would be taken for this pair's.
TEST_F(Files, OfAnEarlierRunAreRemovedWhereTheyAreNotReplaced) {
  const fs::path out = folder_ / "out";
  EXPECT_EQ(RunToEnd(options_).exit_code, 0);
  EXPECT_TRUE(fs::exists(out / "confidence.png"));
  for (const char* name : {"notes.txt", "confidence.png.bak", "truth.pfm", "motion.csv"}) {
    std::ofstream(out / name) << "a user's\n";
  }
  fs::remove(out / "mesh.ply");
  fs::create_directories(out / "mesh.ply");  // empty, and no result
  fs::remove(out / "overview.png");
  fs::create_symlink(folder_ / "left.png", out / "overview.png");
  options_.only = {"depth"};
  EXPECT_EQ(RunToEnd(options_).exit_code, 0);
  std::set<std::string> names;
  for (const auto& entry : fs::directory_iterator(out)) names.insert(entry.path().filename());
  EXPECT_THAT(
      names, testing::ElementsAre("calib.txt", "camera.json", "confidence.png.bak", "depth.pfm",
                                  "depth.png", "mesh.ply", "motion.csv", "notes.txt", "truth.pfm"));
  EXPECT_TRUE(fs::exists(folder_ / "left.png")) << "the link was removed, not its target";
}

TEST_F(Files, ThatCannotBeWrittenLeaveTheOthersAndAreReportedInOrder) {
  for (const char* name : {"l/a.png", "l/b.png", "l/c.png"}) Write(name, scene_.left);
  for (const char* name : {"r/a.png", "r/b.png", "r/c.png"}) Write(name, scene_.right);
  fs::create_directories(folder_ / "out");
  std::ofstream(folder_ / "out" / "b") << "a file in the folder's place\n";
  options_.left = folder_ / "l";
  options_.right = folder_ / "r";
  const MainOutcome outcome = RunToEnd(options_);
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.err, testing::AllOf(HasSubstr("l/b.png: "), HasSubstr("cannot be written"),
                                          HasSubstr("1 of 3 pairs left out\n")));
  EXPECT_LT(outcome.out.find("out/a: "), outcome.out.find("out/c: "));
  EXPECT_TRUE(fs::exists(folder_ / "out" / "c" / "mesh.ply"));
  EXPECT_TRUE(fs::is_regular_file(folder_ / "out" / "b")) << "what was there before stays";
}

TEST_F(Files, ThatCannotBeWrittenLeaveAFolderThatWasThere) {
  std::filesystem::create_directory(options_.out);
  rlimit usual{};
  getrlimit(RLIMIT_FSIZE, &usual);
  const rlimit nothing{.rlim_cur = 0, .rlim_max = usual.rlim_max};
  const auto of_limit = std::signal(SIGXFSZ, SIG_IGN);
  setrlimit(RLIMIT_FSIZE, &nothing);
  const int exit_code = RunFiles(options_, LoadConfig({"default"}), {});
  setrlimit(RLIMIT_FSIZE, &usual);
  std::signal(SIGXFSZ, of_limit);
  std::cerr.clear();  // failed, too, if it goes to a file
  EXPECT_EQ(exit_code, 1);
  EXPECT_TRUE(std::filesystem::is_empty(options_.out));
}

TEST_F(Files, StopBetweenTwoPairs) {
  std::stop_source stop;
  stop.request_stop();
  const MainOutcome outcome = RunToEnd(options_, stop.get_token());
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.err, HasSubstr("stopped after 0 of 1 pairs\n"));
}

// As of a camera of other proportions, whose image was taken for what the left one shows.
// Farther aside than refine moves them, or beside a pair by which it does not judge them.
TEST_F(Files, UseNoRangesThatAreContradicted) {
  const auto dataset = scenes::OpenDataset("synthetic:320x240");
  const scenes::DatasetFrame scene = dataset->Get(0);
  const RectifiedPair& pair = dataset->rig().pair;
  options_.left = Write("left.png", scene.left);
  options_.rig.focal_px = pair.focal_px;
  options_.rig.baseline_m = pair.baseline_m;
  options_.rig.cx = pair.cx;
  options_.rig.cx_right = pair.cx_right;
  const auto outcome_of = [&](int aside, double below, const cv::Mat& right) {
    cv::Mat1w mm(pair.size(), uint16_t{0});
    for (int v = 0; v < mm.rows; ++v) {
      for (int u = aside; u < mm.cols; ++u) {
        const double px = scene.truth.left(v, u - aside);
        const double factor = 1000 * (2 * v < mm.rows ? 1 : below);
        if (std::isfinite(px)) {
          mm(v, u) = static_cast<uint16_t>(factor * pair.DepthFromDisparity(px));
        }
      }
    }
    options_.right = Write("right.png", right);
    options_.tof = Write("tof.png", mm);
    const MainOutcome outcome = RunToEnd(options_);
    EXPECT_EQ(outcome.exit_code, 1);
    return outcome.err;
  };
  EXPECT_THAT(outcome_of(48, 1, scene.right),
              testing::ContainsRegex("belong about 48 px.*; no range is believed"));
  cv::Mat lower;
  cv::warpAffine(scene.right, lower, cv::Matx23d(1, 0, 0, 0, 1, 3), scene.right.size());
  EXPECT_THAT(outcome_of(0, 0.6, lower),
              testing::ContainsRegex("ranges and images disagree .*; no range is believed"));
  EXPECT_THAT(outcome_of(0, 0.6, scene.right), Not(HasSubstr("no range is believed")));
  EXPECT_THAT(outcome_of(0, 1, lower), Not(HasSubstr("no range is believed")));
}

TEST_F(Files, SayThatPixelsOfRangeImagesAreOblong) {
  options_.tof = folder_ / "tof.pfm";
  EXPECT_THAT(RunToEnd(options_).err, Not(HasSubstr("as wide as high")));
  const cv::Mat1f narrow = tof_.depth_m.colRange(1, tof_.depth_m.cols - 1);
  ASSERT_TRUE(WritePfm(folder_ / "tof.pfm", narrow.clone()));
  EXPECT_THAT(RunToEnd(options_).err,
              HasSubstr("pixels of range images of 38x30 are 1.05 times as wide as high over left "
                        "images of 160x120"));
}

}  // namespace
}  // namespace sprout
