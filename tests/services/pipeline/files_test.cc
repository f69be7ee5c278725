#include "services/pipeline/files/files.h"

#include <gmock/gmock.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <opencv2/imgcodecs.hpp>
#include <set>

#include "common/core/input_files.h"
#include "common/core/read_text.h"
#include "common/geometry/projection.h"
#include "common/picture/write_image.h"
#include "common/rig/rectifier.h"
#include "common/rig/rig_file.h"
#include "services/datasets/dataset.h"
#include "services/datasets/middlebury_calibration.h"
#include "services/datasets/pfm.h"
#include "services/pipeline/pipeline.h"
#include "tests/common/picture/temporary_directory.h"

namespace sprout {
namespace {

namespace fs = std::filesystem;

using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;

constexpr int kTofStep = 4;
constexpr double kInf = std::numeric_limits<double>::infinity();

bool SameBytes(const cv::Mat& a, const cv::Mat& b) {
  return a.type() == b.type() && a.size() == b.size() && a.isContinuous() && b.isContinuous() &&
         std::memcmp(a.data, b.data, a.total() * a.elemSize()) == 0;
}

struct Ended {
  int exit_code = 0;
  std::string out;
  std::string err;
};

Ended RunToEnd(const FilesOptions& options, const std::stop_token& stop = {}) {
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  Ended outcome;
  outcome.exit_code = RunFiles(options, LoadConfig({"default"}), stop);
  outcome.out = testing::internal::GetCapturedStdout();
  outcome.err = testing::internal::GetCapturedStderr();
  return outcome;
}

std::string RefusalOf(const FilesOptions& options) {
  try {
    RunFiles(options, LoadConfig({"default"}), {});
  } catch (const ConfigError& e) {
    return e.what();
  }
  return "not refused";
}

// A scene whose principal points differ, and a depth image in the left camera's place.
class Files : public testing::Test {
 protected:
  Files() {
    CaptureConfig config;
    config.set_source("synthetic:160x120");
    const auto dataset = datasets::OpenDataset(config);
    scene_ = dataset->Get(0);
    pair_ = dataset->rig().pair;
    cv::Mat1w tof_mm(pair_.height / kTofStep, pair_.width / kTofStep);
    for (int v = 0; v < tof_mm.rows; ++v) {
      for (int u = 0; u < tof_mm.cols; ++u) {
        const float px = scene_.truth.left(v * kTofStep + 2, u * kTofStep + 2);
        const double mm = 1000 * pair_.DepthFromDisparity(double{px});
        tof_mm(v, u) = std::isfinite(mm) ? static_cast<uint16_t>(std::lround(mm)) : uint16_t{0};
      }
    }
    tof_mm.convertTo(tof_.depth_m, CV_32F, 0.001);
    Write("left.png", scene_.left);
    Write("right.png", scene_.right);
    EXPECT_TRUE(WritePfm(folder_ / "tof.pfm", tof_.depth_m));
    Write("tof.png", tof_mm);
    options_.left = folder_ / "left.png";
    options_.right = folder_ / "right.png";
    options_.out = folder_ / "out";
    options_.rig.focal_px = pair_.focal_px;
    options_.rig.baseline_m = pair_.baseline_m;
    options_.rig.cx = pair_.cx;
    options_.rig.cx_right = pair_.cx_right;
  }

  std::string Write(const char* name, const cv::Mat& image) const {
    fs::create_directories((folder_ / name).parent_path());
    EXPECT_TRUE(cv::imwrite(folder_ / name, image)) << name;
    return folder_ / name;
  }

  // The calibration that the flags stand for.
  Rig RigOfFlags() const {
    Rig rig;
    rig.pair = pair_;
    rig.pair.cy = (pair_.height - 1) / 2.0;
    rig.tof.width = tof_.depth_m.cols;
    rig.tof.height = tof_.depth_m.rows;
    rig.tof.fx = rig.tof.fy = pair_.focal_px / kTofStep;
    rig.tof.cx = (pair_.cx + 0.5) / kTofStep - 0.5;
    rig.tof.cy = (rig.pair.cy + 0.5) / kTofStep - 0.5;
    return rig;
  }

  DepthFrame Expected(const TofImage& tof, Rig rig) const {
    if (tof.depth_m.empty()) rig.tof = TofCamera();
    return Pipeline(LoadConfig({"default"})).Compute(scene_.left, scene_.right, tof, rig).value();
  }

  void ExpectResults(const DepthFrame& expected, const RectifiedPair& pair) const {
    const auto png = [&](const char* name) {
      return cv::imread(folder_ / "out" / name, cv::IMREAD_UNCHANGED);
    };
    cv::Mat1f px(expected.disparity.size());
    cv::Mat1w counts(px.size());
    cv::Mat1w mm(px.size());
    for (int v = 0; v < px.rows; ++v) {
      for (int u = 0; u < px.cols; ++u) {
        const bool valid = expected.disparity.IsValid(u, v);
        px(v, u) = valid ? expected.disparity.Px(u, v) : static_cast<float>(kInf);
        // 0 is "none" in the file, so a disparity of 0 is written as 1.
        counts(v, u) =
            valid ? static_cast<uint16_t>(std::max(std::lround(px(v, u) * 32), 1L)) : uint16_t{0};
        const float depth_m = expected.depth_m(v, u);
        mm(v, u) =
            depth_m < 65 ? static_cast<uint16_t>(std::lround(double{depth_m} * 1000)) : uint16_t{0};
      }
    }
    EXPECT_TRUE(SameBytes(datasets::ReadPfm(folder_ / "out" / "disparity.pfm"), px));
    EXPECT_TRUE(SameBytes(png("disparity.png"), counts));
    EXPECT_TRUE(SameBytes(datasets::ReadPfm(folder_ / "out" / "depth.pfm"), expected.depth_m));
    EXPECT_TRUE(SameBytes(png("depth.png"), mm));
    EXPECT_TRUE(SameBytes(png("confidence.png"), expected.confidence));
    EXPECT_TRUE(SameBytes(datasets::ReadPfm(folder_ / "out" / "depth_sigma.pfm"),
                          DepthSigmaMap(pair, expected.disparity, expected.sigma)));
    EXPECT_GE(png("overview.png").cols, 2 * pair_.width);
    for (const char* name : {"cloud.ply", "mesh.ply"}) {
      std::string text(1000, '\0');
      std::ifstream(folder_ / "out" / name).read(text.data(), 1000);
      const auto vertices = cv::countNonZero(expected.depth_m == expected.depth_m);
      EXPECT_THAT(text, HasSubstr("element vertex " + std::to_string(vertices) + "\n")) << name;
    }
  }

  TemporaryDirectory folder_;
  datasets::DatasetFrame scene_;
  RectifiedPair pair_;
  TofImage tof_;
  FilesOptions options_;
};

TEST_F(Files, HoldWhatThePipelineComputesOfAPairAndADepthImage) {
  const DepthFrame expected = Expected(tof_, RigOfFlags());
  ASSERT_GT(expected.disparity.CountValid(), 0.9 * pair_.size().area());
  for (const char* tof : {"tof.pfm", "tof.png"}) {
    options_.tof = folder_ / tof;
    const Ended outcome = RunToEnd(options_);
    EXPECT_EQ(outcome.exit_code, 0) << tof;
    EXPECT_THAT(outcome.err, IsEmpty()) << tof;
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
  EXPECT_THAT(RunToEnd(options_).err,
              HasSubstr("small.png: the left image is 80x60: allowed is the "
                        "calibrated size 160x120\n"));
  options_.left = folder_ / "left.png";
  options_.tof = folder_ / "tof.png";
  EXPECT_THAT(RunToEnd(options_).err, HasSubstr("left.png: the ToF image is 40x30: allowed is the "
                                                "calibrated size 0x0\n"));
}

TEST_F(Files, OfManyPairsAreComputedButForTheOnesThatCannotBe) {
  for (const char* name : {"l/b.png", "l/a.png", "l/c.png"}) Write(name, scene_.left);
  for (const char* name : {"r/1.png", "r/3.png"}) Write(name, scene_.right);
  Write("r/2.png", cv::Mat(60, 80, CV_8UC1, cv::Scalar(0)));
  std::ofstream(folder_ / "l" / "notes.txt") << "no image\n";
  options_.left = folder_ / "l";
  options_.right = folder_ / "r/?.png";
  const Ended outcome = RunToEnd(options_);
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
  CaptureConfig capture;
  capture.set_source("synthetic:160x120");
  const auto dataset = datasets::OpenDataset(capture);
  const std::vector<std::string> configs = {"default", "temporal { in_pipeline: true }",
                                            "depth { input: FUSED }"};
  Pipeline pipeline(LoadConfig(configs));
  std::vector<DepthFrame> expected;
  Rig rig = RigOfFlags();
  rig.tof = TofCamera();
  for (int i = 0; i < 3; ++i) {
    const datasets::DatasetFrame frame = dataset->Get(i);
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
    EXPECT_TRUE(SameBytes(datasets::ReadPfm(out / "depth.pfm"), frame.depth_m));
    EXPECT_TRUE(SameBytes(cv::imread(out / "fused_confidence.png", cv::IMREAD_UNCHANGED),
                          frame.fused_confidence));
    EXPECT_TRUE(fs::exists(out / "fused.pfm"));
    const cv::Mat fused = cv::imread(out / "fused.png", cv::IMREAD_UNCHANGED);
    const cv::Mat single = cv::imread(out / "disparity.png", cv::IMREAD_UNCHANGED);
    EXPECT_EQ(cv::countNonZero(fused), frame.fused.CountValid());
    EXPECT_EQ(SameBytes(fused, single), i == 0);
  }
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
    const cv::Mat1f depth_m = datasets::ReadPfm(folder_ / "out" / "depth.pfm");
    const cv::Mat1f sigma_m = datasets::ReadPfm(folder_ / "out" / "depth_sigma.pfm");
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
    const cv::Mat1f px = datasets::ReadPfm(folder_ / "out" / "disparity.pfm");
    EXPECT_EQ(cv::countNonZero(px < kInf), all.disparity.CountValid());
  }
}

TEST_F(Files, HaveTheCalibrationBesideThem) {
  EXPECT_EQ(RunToEnd(options_).exit_code, 0);
  const RectifiedPair pair =
      datasets::CalibrationFromCalib(folder_ / "out" / "calib.txt", pair_.size());
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
    try {
      RunFiles(options_, LoadConfig({"default", "depth { " + setting + " }"}), {});
      ADD_FAILURE() << setting << " is not refused";
    } catch (const ConfigError& e) {
      EXPECT_THAT(e.what(), StartsWith(text));
    }
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

TEST_F(Files, ThatCannotBeWrittenLeaveTheOthersAndAreReportedInOrder) {
  for (const char* name : {"l/a.png", "l/b.png", "l/c.png"}) Write(name, scene_.left);
  for (const char* name : {"r/a.png", "r/b.png", "r/c.png"}) Write(name, scene_.right);
  fs::create_directories(folder_ / "out");
  std::ofstream(folder_ / "out" / "b") << "a file in the folder's place\n";
  options_.left = folder_ / "l";
  options_.right = folder_ / "r";
  const Ended outcome = RunToEnd(options_);
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.err, testing::AllOf(HasSubstr("l/b.png: "), HasSubstr("cannot be written"),
                                          HasSubstr("1 of 3 pairs left out\n")));
  EXPECT_LT(outcome.out.find("out/a: "), outcome.out.find("out/c: "));
  EXPECT_TRUE(fs::exists(folder_ / "out" / "c" / "mesh.ply"));
  EXPECT_TRUE(fs::is_regular_file(folder_ / "out" / "b")) << "what was there before stays";
}

TEST_F(Files, StopBetweenTwoPairs) {
  std::stop_source stop;
  stop.request_stop();
  const Ended outcome = RunToEnd(options_, stop.get_token());
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.err, HasSubstr("stopped after 0 of 1 pairs\n"));
}

TEST_F(Files, ThatCannotBeUsedAreRefusedBeforeAnythingIsComputed) {
  const std::string nothing = folder_ / "nothing";
  const std::string empty = folder_ / "empty";
  fs::create_directories(empty);
  Write("two/1.png", scene_.left);
  Write("two/2.png", scene_.left);
  Write("two/2.bmp", scene_.left);
  const std::string blocked = folder_ / "left.png/out";
  const struct {
    std::function<void(FilesOptions&)> change;
    std::string text;
  } table[] = {
      {[&](auto& o) { o.left = nothing; }, "LEFT " + nothing + ": not there; allowed: "},
      {[&](auto& o) { o.right = empty; }, "RIGHT " + empty + ": holds no image"},
      {[&](auto& o) { o.tof = nothing + "*"; }, "--tof " + nothing + "*: no file is called so"},
      {[&](auto& o) { o.left = folder_ / "two/*.png"; },
       "LEFT and RIGHT: neither times nor names say which of 2 and 1 files belong together"},
      {[&](auto& o) { o.left = o.right = folder_ / "two"; }, "LEFT: images of one name"},
      {[&](auto& o) { o.rig = {}; }, "no calibration; allowed: --rig FILE, or of a rectified pair"},
      {[&](auto& o) { o.pixels.tof_unit = "1/0"; }, "--tof-unit 1/0: allowed: mm, cm, m, 1/N"},
      {[&](auto& o) { o.rig.rig_file = nothing; }, nothing},
      {[&](auto& o) { o.out = blocked; }, "--out " + blocked + ": cannot be written ("},
  };
  for (const auto& [change, text] : table) {
    FilesOptions options = options_;
    change(options);
    EXPECT_THAT(RefusalOf(options), HasSubstr(text));
  }
}

TEST_F(Files, ThatAreReadAreNotReplaced) {
  const InputFileGuard guard;
  options_.tof = Write("out/depth.png", cv::Mat1w(30, 40, uint16_t{2000}));
  EXPECT_THAT(RefusalOf(options_), HasSubstr("depth.png is an input of this run"));
  EXPECT_EQ(cv::imread(options_.tof, cv::IMREAD_UNCHANGED).at<uint16_t>(0, 0), 2000);
  // The second pair's, by the first one's results, through a link.
  const std::string read = Write("out/1/overview.png", scene_.left);
  for (const char* name : {"l/1.png", "l/2.png", "r/1.png"}) Write(name, scene_.left);
  fs::create_symlink(read, folder_ / "r/2.png");
  options_.left = folder_ / "l";
  options_.right = folder_ / "r";
  options_.tof.clear();
  EXPECT_THAT(RefusalOf(options_), HasSubstr("overview.png is an input of this run"));
}

TEST_F(Files, WhoseNamesAreStepsUpAreRefused) {
  for (const char* name : {"up/...png", "up/..png"}) {
    const std::string path = folder_ / name;
    fs::create_directories(folder_ / "up");
    ASSERT_TRUE(WritePng(path, scene_.left));
    options_.left = folder_ / "up/.*png";
    EXPECT_THAT(RefusalOf(options_), HasSubstr("its results would go to")) << name;
    fs::remove(path);
  }
}

TEST_F(Files, WhoseContentCannotBeUsedGetOneLine) {
  std::ofstream(folder_ / "text.png") << "no image\n";
  std::ofstream(folder_ / "short.pfm") << "Pf\n40 30\n-1\nabc";
  const struct {
    std::function<void(FilesOptions&)> change;
    std::string text;
  } table[] = {
      {[&](auto& o) { o.left = folder_ / "text.png"; }, "text.png: "},
      {[&](auto& o) { o.tof = folder_ / "left.png"; },
       "left.png: of OpenCV's type CV_8UC3; allowed: one channel of 16 bits (mm), or of floating "
       "point (m; PFM, TIFF)\n"},
      {[&](auto& o) { o.tof = folder_ / "short.pfm"; }, "short.pfm: ends early"},
      {[&](auto& o) { o.rig.focal_px = std::nan(""); }, "focal_px"},
      {[&](auto& o) { o.rig.baseline_m = 0; }, "baseline_m"},
  };
  for (const auto& [change, text] : table) {
    FilesOptions options = options_;
    change(options);
    const Ended outcome = RunToEnd(options);
    EXPECT_EQ(outcome.exit_code, 1) << text;
    EXPECT_THAT(outcome.err, HasSubstr(text));
    EXPECT_FALSE(fs::exists(folder_ / "out")) << "an empty folder is left";
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  }
}

}  // namespace
}  // namespace sprout
