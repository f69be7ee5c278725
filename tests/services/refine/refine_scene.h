#pragma once

#include <limits>
#include <opencv2/imgproc.hpp>

#include "services/refine/refine_adapter.h"
#include "services/refine/refiner.h"
#include "tests/common/config/with.h"
#include "tests/common/core/centred.h"

// What the tests of refinement look at.
namespace sprout::refine {

inline constexpr float kNoReturn = std::numeric_limits<float>::quiet_NaN();

// A ToF camera of 10×8 pixels in the left camera's place, one ToF pixel every 10 image pixels;
// ToF pixel (i, j) looks at image pixel (10·i, 10·j).
inline Rig MakeRig() {
  Rig rig{CentredPair(100, 80, 100), CentredTof(10, 8, 10)};
  rig.pair.cx_right = 52;
  return rig;
}

// The paper's rules alone: the made-up ToF images hold single points, which all hang loose.
inline RefineConfig PaperRules() {
  return With<RefineConfig>("loose_tolerance_px: 0 hidden_reach: 0 stereo_seeds: false");
}

struct Scene {
  Rig rig = MakeRig();
  cv::Mat1b left = cv::Mat1b(80, 100, uint8_t{100});
  cv::Mat1b right = cv::Mat1b(80, 100, uint8_t{100});
  TofImage tof{.depth_m = cv::Mat1f(8, 10, kNoReturn), .amplitude = {}};

  void SetDisparity(int i, int j, double disparity) {
    tof.depth_m(j, i) = static_cast<float>(rig.pair.DepthFromDisparity(disparity));
  }

  Result<SeedSet> Refine(const RefineConfig& config = PaperRules()) const {
    return Refiner(config).Compute(left, right, tof, TofProjector(rig));
  }
};

// Texture, 12 px of disparity everywhere.
inline Scene TexturedScene() {
  Scene scene;
  cv::RNG(3).fill(scene.left, cv::RNG::UNIFORM, 0, 256);
  cv::GaussianBlur(scene.left, scene.left, {}, 1);
  scene.left.colRange(12, 100).copyTo(scene.right.colRange(0, 88));
  return scene;
}

// A wall at 12 px with two boxes before it, at 17 and 20 px, and a ToF camera in the left camera's
// place that sees every fifth pixel.
struct BoxScene : Scene {
  static double DisparityAt(int u, int v) {
    if (cv::Rect(60, 40, 90, 80).contains({u, v})) return 17;
    if (cv::Rect(220, 140, 110, 90).contains({u, v})) return 20;
    return 12;
  }

  // @param move_px  how far right of where they belong the points lie.
  // @param spread   by what their distances from the middle have to be multiplied.
  explicit BoxScene(int move_px = 0, double spread = 1) {
    constexpr int kStep = 5;
    const cv::Size size(400, 300);
    rig.pair.width = size.width;
    rig.pair.height = size.height;
    rig.pair.cx = rig.pair.cx_right = 200;
    rig.pair.cy = 150;
    rig.tof.width = size.width / kStep;
    rig.tof.height = size.height / kStep;
    rig.tof.fx = rig.tof.fy = rig.pair.focal_px / kStep;
    rig.tof.cx = rig.pair.cx / kStep;
    rig.tof.cy = rig.pair.cy / kStep;
    left.create(size);
    cv::RNG(5).fill(left, cv::RNG::UNIFORM, 0, 256);
    cv::GaussianBlur(left, left, {}, 1);
    right.create(size);
    cv::RNG(6).fill(right, cv::RNG::UNIFORM, 0, 256);
    for (const int disparity : {12, 17, 20}) {  // the nearest last
      for (int v = 0; v < size.height; ++v) {
        for (int u = disparity; u < size.width; ++u) {
          if (DisparityAt(u, v) == disparity) right(v, u - disparity) = left(v, u);
        }
      }
    }
    tof.depth_m.create(rig.tof.height, rig.tof.width);
    for (int j = 0; j < rig.tof.height; ++j) {
      for (int i = 0; i < rig.tof.width; ++i) {
        const cv::Point2d middle(rig.pair.cx, rig.pair.cy);
        const cv::Point at =
            middle + spread * (cv::Point2d(kStep * i - move_px, kStep * j) - middle);
        SetDisparity(i, j, DisparityAt(at.x, at.y));
      }
    }
  }
};

inline Frame FrameOf(const Scene& scene) {
  Frame frame;
  frame.left = scene.left;
  frame.right = scene.right;
  frame.tof = scene.tof;
  frame.rig = scene.rig;
  frame.id.rig_id = RigId(scene.rig);
  return frame;
}

}  // namespace sprout::refine
