#pragma once

#include <gmock/gmock.h>

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <string>

#include "common/scenes/pfm.h"
#include "services/pipeline/files/files.h"
#include "tests/common/app/run_main.h"
#include "tests/common/picture/temporary_directory.h"

namespace sprout {

inline const cv::Size kSize{96, 72};
inline constexpr double kFocalPx = 90;
inline constexpr double kBaselineM = 0.1;
inline constexpr int kFarPx = 4;    // disparity of the background: 2.25 m
inline constexpr int kNearPx = 10;  // of a box in the middle: 0.90 m
inline const cv::Rect kBox(36, 24, 26, 26);

// Noise that is the same for equal places, so that views of it match.
inline uint8_t Texture(int x, int y) {
  uint32_t hash =
      static_cast<uint32_t>(x + 1000) * 73856093U ^ static_cast<uint32_t>(y) * 19349663U;
  hash = (hash ^ (hash >> 13)) * 1274126177U;
  return static_cast<uint8_t>(20 + (hash >> 16) % 200);
}

// Depth, m, at a pixel of the left image.
inline double DepthAt(int u, int v, int shift = 0) {
  const bool near = kBox.contains({u - shift, v});
  return kFocalPx * kBaselineM / (near ? kNearPx : kFarPx);
}

// A box before a wall. The right image is moved by whole pixels: cx' = cx + move.
struct Scene {
  explicit Scene(int box_shift = 0, int move = 0) : left(kSize), right(kSize) {
    for (int v = 0; v < kSize.height; ++v) {
      for (int u = 0; u < kSize.width; ++u) {
        left(v, u) = At(u, v, box_shift, 0);
        right(v, u) = At(u - move, v, box_shift, 1);
      }
    }
  }

  // The grey value that the left (0) or the right (1) camera sees.
  static uint8_t At(int u, int v, int box_shift, int right) {
    const int in_box = u + right * kNearPx;
    if (kBox.contains({in_box - box_shift, v})) return Texture(in_box - box_shift + 500, v);
    return Texture(u + right * kFarPx, v);
  }

  cv::Mat1b left, right;
};

inline cv::Mat1w RangePicture(double counts_per_metre) {
  cv::Mat1w tof(kSize);
  for (int v = 0; v < kSize.height; ++v) {
    for (int u = 0; u < kSize.width; ++u) {
      tof(v, u) = static_cast<uint16_t>(std::lround(DepthAt(u, v) * counts_per_metre));
    }
  }
  return tof;
}

// `sprout-pipeline files` of such a scene.
class FilesOfBox : public testing::Test {
 protected:
  FilesOfBox() {
    options_.out = Path("out");
    options_.rig.focal_px = kFocalPx;
    options_.rig.baseline_m = kBaselineM;
    Show(Scene());
  }

  std::string Path(const std::string& name) const { return folder_ / name.c_str(); }

  std::string Write(const std::string& name, const cv::Mat& image) const {
    std::filesystem::create_directories(std::filesystem::path(Path(name)).parent_path());
    EXPECT_TRUE(cv::imwrite(Path(name), image)) << name;
    return Path(name);
  }

  void Show(const Scene& scene) {
    options_.left = Write("left.png", scene.left);
    options_.right = Write("right.png", scene.right);
  }

  int Run() {
    std::string refusal;
    const MainOutcome outcome = Captured([&] {
      try {
        return RunFiles(options_, LoadConfig({"default"}), {});
      } catch (const ConfigError& e) {
        refusal = e.what();
        return 2;
      }
    });
    out_ = outcome.out;
    err_ = refusal + outcome.err;
    return outcome.exit_code;
  }

  cv::Mat1f Depth(const std::string& folder = "out") const {
    return scenes::ReadPfm(Path(folder + "/depth.pfm"));
  }

  // Percentage of the pixels whose depth is right within 3 %, away from the borders.
  double Right(const cv::Mat1f& depth_m, int box_shift = 0) const {
    constexpr int kBorder = 12;
    int right = 0;
    int all = 0;
    for (int v = kBorder; v < depth_m.rows - kBorder; ++v) {
      for (int u = 2 * kBorder; u < depth_m.cols - 2 * kBorder; ++u) {
        ++all;
        right += std::abs(depth_m(v, u) / DepthAt(u, v, box_shift) - 1) < 0.03 ? 1 : 0;
      }
    }
    return 100.0 * right / all;
  }

  TemporaryDirectory folder_;
  FilesOptions options_;
  std::string out_;
  std::string err_;
};

}  // namespace sprout
