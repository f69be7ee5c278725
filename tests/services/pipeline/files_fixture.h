#pragma once

#include <gmock/gmock.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <opencv2/imgcodecs.hpp>
#include <stop_token>
#include <string>
#include <vector>

#include "common/geometry/projection.h"
#include "common/picture/write_image.h"
#include "common/scenes/dataset.h"
#include "common/scenes/pfm.h"
#include "services/pipeline/files/files.h"
#include "services/pipeline/pipeline.h"
#include "tests/common/app/run_main.h"
#include "tests/common/picture/temporary_directory.h"
#include "tests/common/testing/thrown.h"

namespace sprout {

inline constexpr int kTofStep = 4;

inline bool SameBytes(const cv::Mat& a, const cv::Mat& b) {
  return a.type() == b.type() && a.size() == b.size() && a.isContinuous() && b.isContinuous() &&
         std::memcmp(a.data, b.data, a.total() * a.elemSize()) == 0;
}

inline MainOutcome RunToEnd(const FilesOptions& options, const std::stop_token& stop = {},
                            const std::vector<std::string>& configs = {"default"}) {
  return Captured([&] { return RunFiles(options, LoadConfig(configs), stop); });
}

inline std::string RefusalOf(const FilesOptions& options) {
  return Thrown<ConfigError>([&] { RunFiles(options, LoadConfig({"default"}), {}); });
}

// A scene whose principal points differ, and a depth image in the left camera's place.
class Files : public testing::Test {
 protected:
  Files() {
    const auto dataset = scenes::OpenDataset("synthetic:160x120");
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
    std::filesystem::create_directories((folder_ / name).parent_path());
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
        px(v, u) = valid ? expected.disparity.Px(u, v) : std::numeric_limits<float>::infinity();
        // 0 is "none" in the file, so a disparity of 0 is written as 1.
        counts(v, u) =
            valid ? static_cast<uint16_t>(std::max(std::lround(px(v, u) * 32), 1L)) : uint16_t{0};
        const float depth_m = expected.depth_m(v, u);
        mm(v, u) =
            depth_m < 65 ? static_cast<uint16_t>(std::lround(double{depth_m} * 1000)) : uint16_t{0};
      }
    }
    EXPECT_TRUE(SameBytes(scenes::ReadPfm(folder_ / "out" / "disparity.pfm"), px));
    EXPECT_TRUE(SameBytes(png("disparity.png"), counts));
    EXPECT_TRUE(SameBytes(scenes::ReadPfm(folder_ / "out" / "depth.pfm"), expected.depth_m));
    EXPECT_TRUE(SameBytes(png("depth.png"), mm));
    EXPECT_TRUE(SameBytes(png("confidence.png"), expected.confidence));
    EXPECT_TRUE(SameBytes(scenes::ReadPfm(folder_ / "out" / "depth_sigma.pfm"),
                          DepthSigmaMap(pair, expected.disparity, expected.sigma)));
    EXPECT_GE(png("overview.png").cols, 2 * pair_.width);
    for (const char* name : {"cloud.ply", "mesh.ply"}) {
      std::string text(1000, '\0');
      std::ifstream(folder_ / "out" / name).read(text.data(), 1000);
      const auto vertices = cv::countNonZero(expected.depth_m == expected.depth_m);
      EXPECT_THAT(text, testing::HasSubstr("element vertex " + std::to_string(vertices) + "\n"))
          << name;
    }
  }

  TemporaryDirectory folder_;
  scenes::DatasetFrame scene_;
  RectifiedPair pair_;
  TofImage tof_;
  FilesOptions options_;
};

}  // namespace sprout
