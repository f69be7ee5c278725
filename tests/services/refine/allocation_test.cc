// Refinement must not allocate once it has seen a frame.
#include <gtest/gtest.h>

#include <opencv2/core.hpp>
#include <random>
#include <utility>

#include "services/refine/refiner.h"
#include "tests/common/testing/allocation_guard.h"

namespace sprout {
namespace {

// A ToF camera of 40×30 pixels beside the left one; its columns and rows lie 5 px apart.
Rig SomeRig() {
  Rig rig;
  rig.pair = {.width = 200,
              .height = 150,
              .focal_px = 200,
              .cx = 100,
              .cy = 75,
              .cx_right = 100,
              .baseline_m = 0.1};
  rig.tof.width = 40;
  rig.tof.height = 30;
  rig.tof.fx = rig.tof.fy = 40;
  rig.tof.cx = 20;
  rig.tof.cy = 15;
  rig.tof.left_from_tof_translation_m.x() = -0.05;
  return rig;
}

// Noise, and before it two surfaces that every rule finds something to drop on.
struct Input {
  Input(const Rig& rig, uint32_t seed)
      : left(rig.pair.size()),
        right(rig.pair.size()),
        tof{.depth_m = cv::Mat1f(rig.tof.height, rig.tof.width),
            .amplitude = cv::Mat1f(rig.tof.height, rig.tof.width, 100.F)} {
    std::mt19937 random(seed);
    for (uint8_t& value : left) value = static_cast<uint8_t>(random());
    for (uint8_t& value : right) value = static_cast<uint8_t>(random());
    left(cv::Rect(0, 0, 60, 40)) = 0;
    for (int v = 0; v < tof.depth_m.rows; ++v) {
      for (int u = 0; u < tof.depth_m.cols; ++u) {
        const bool near = u > 15 && u < 25;
        tof.depth_m(v, u) = random() % 50 == 0 ? 0.5F : near ? 1 : 2.5F;
      }
    }
  }

  cv::Mat1b left;
  cv::Mat1b right;
  TofImage tof;
};

TEST(Allocation, RefinementAllocatesNothingInSteadyState) {
  cv::setNumThreads(1);  // handing work to other threads is OpenCV's business
  const Rig rig = SomeRig();
  const TofProjector projector(rig);
  const Input first(rig, 1);
  const Input second(rig, 2);
  RefineConfig config;
  config.set_background_tolerance_px(1);
  Refiner refiner(config);
  SeedSet seeds;
  const auto run = [&](const Input& input) {
    seeds =
        refiner.Compute(input.left, input.right, input.tof, projector, std::move(seeds)).value();
  };
  run(second);
  run(first);
  {
    const AllocationGuard guard;
    run(second);
    run(first);
    EXPECT_EQ(guard.count(), 0);
  }
  EXPECT_GT(seeds.seeds.size(), 0U);
  for (const int32_t dropped :
       {seeds.outside, seeds.dark, seeds.loose, seeds.background, seeds.hidden}) {
    EXPECT_GT(dropped, 0);
  }
  // Without memory of an earlier frame the seeds themselves are all that it allocates.
  const AllocationGuard guard;
  const auto again = refiner.Compute(first.left, first.right, first.tof, projector);
  EXPECT_LE(guard.count(), 1);
  EXPECT_EQ(*again, seeds);
}

}  // namespace
}  // namespace sprout
