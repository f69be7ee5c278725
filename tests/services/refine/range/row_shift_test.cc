#include "services/refine/range/row_shift.h"

#include <gtest/gtest.h>

#include <functional>
#include <opencv2/imgproc.hpp>

#include "services/refine/refiner.h"
#include "tests/services/refine/range/wall.h"

namespace sprout::refine {
namespace {

// Rows that are exposed one after the other, the lower half of another moment, one of long ago.
TEST(RowShift, BelievesASensorBesideRowsThatAreShifted) {
  const std::function<double(int)> shifts_px[] = {
      [](int v) { return 6.0 * v / kWallSize.height - 3; },
      [](int v) { return v < kWallSize.height / 2 ? 0 : 5; },
      [](int v) { return v < kWallSize.height / 2 ? 0 : -18; }};
  for (const auto& shift_px : shifts_px) {
    Wall wall;
    cv::Mat1f columns(kWallSize);
    cv::Mat1f rows(kWallSize);
    for (int v = 0; v < kWallSize.height; ++v) {
      for (int u = 0; u < kWallSize.width; ++u) {
        columns(v, u) = static_cast<float>(u + shift_px(v));
        rows(v, u) = static_cast<float>(v);
      }
    }
    cv::remap(wall.right.clone(), wall.right, columns, rows, cv::INTER_LINEAR, cv::BORDER_REFLECT);
    Refiner refiner{RefineConfig()};
    const auto set = refiner.Compute(wall.left, wall.right, wall.tof, TofProjector(wall.rig));
    EXPECT_TRUE(refiner.found().range_error.rows_shifted);
    EXPECT_EQ(set->contradicted, 0);
    EXPECT_GT(set->seeds.size(), 4000U);
    EXPECT_GT(ShareWithin(*set, 0.4), 0.97);
  }
}

// Its errors are those of rows, too, but in parts of the depth.
TEST(RowShift, MovesPointsThatAreTooFarInTheLowerRows) {
  Wall wall;
  wall.Measure([&](const cv::Point2d& at, double depth_m) {
    return at.y < kWallSize.height / 2.0 ? depth_m : 1.06 * depth_m;
  });
  Refiner refiner{RefineConfig()};
  const auto set = refiner.Compute(wall.left, wall.right, wall.tof, TofProjector(wall.rig));
  EXPECT_FALSE(refiner.found().range_error.pair_unfit);
  EXPECT_GT(ShareWithin(*set, 0.4), 0.8);
}

// Ranges in a wrong unit put all at infinity; the disparities of a floor are those of its rows.
TEST(RowShift, IsNotToldFromPointsAtInfinity) {
  cv::RNG random(1);
  std::vector<ProjectedPoint> points;
  std::vector<Seed> matches;
  for (int v = 5; v < kWallSize.height; v += 5) {
    for (int u = 5; u < kWallSize.width; u += 5) {
      const Seed match{.u = static_cast<float>(u),
                       .v = static_cast<float>(v),
                       .u_right = static_cast<float>(u - 0.1 * v)};
      matches.push_back(match);
      points.push_back({.tof_u = u, .tof_v = v, .seed = match});
      points.back().seed.u_right = match.u - match.disparity() * random.uniform(0.9F, 1.1F) / 1000;
    }
  }
  EXPECT_FALSE(ShiftsRows(
      {.raw = {}, .corrected = points, .spacing_px = {5, 5}, .image = kWallSize, .infinity_px = 0},
      matches));
}

}  // namespace
}  // namespace sprout::refine
