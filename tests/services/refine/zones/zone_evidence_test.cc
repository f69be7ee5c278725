#include "services/refine/zones/zone_evidence.h"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>

#include "tests/services/refine/refine_scene.h"

namespace sprout::refine {
namespace {

constexpr float kInfinite = std::numeric_limits<float>::infinity();

// MakeRig(): d = 10 / z − 2.
double DepthOf(double disparity_px) { return 10 / (disparity_px + 2); }

// Cells of 5 px: 20 × 16 of them.
CellGrid Grid() { return {5, MakeRig().pair.size()}; }

// In the left camera's place, its field of view; `columns` × `rows` zones with a target at 2 m, d = 3.
TofZones Zones(int columns, int rows = 1) {
  TofZones zones{.columns = columns, .rows = rows, .left_from_sensor = {}, .views = {}, .targets = {}};
  const auto at = [](double side, int index, int count) {
    return static_cast<float>(side * (2.0 * index / count - 1));
  };
  for (int v = 0; v < rows; ++v) {
    for (int u = 0; u < columns; ++u) {
      zones.views.push_back({at(0.505, u, columns), at(0.505, u + 1, columns), at(0.405, v, rows),
                             at(0.405, v + 1, rows)});
      zones.targets.push_back({2, 0.1F, TargetStatus::kValid});
    }
  }
  return zones;
}

ZoneEvidence EvidenceOf(const TofZones& zones) {
  ZoneEvidence evidence;
  const Result<void> set = evidence.Set(zones, MakeRig().pair, Grid());
  EXPECT_TRUE(set) << set.error().text;
  return evidence;
}

TEST(ZoneEvidence, SaysNothingWithoutZones) {
  const ZoneEvidence evidence = EvidenceOf({});
  EXPECT_TRUE(evidence.bounds().empty());
  EXPECT_FALSE(evidence.SurfaceAt({0, 0}));
}

TEST(ZoneEvidence, BoundsDisparitiesByTheZonesWithinReach) {
  TofZones zones = Zones(4);
  zones.targets[0].depth_m = 1;
  zones.targets[3] = {0.5F, 0.05F, TargetStatus::kDoubtful};
  const DisparityBounds bounds = EvidenceOf(zones).bounds();
  EXPECT_EQ(bounds.spacing_px, 5);
  // By hand: 10 / (z ± 0.3) − 2; a zone has five columns of cells.
  const double least = 10 / 2.3 - 2, most = 10 / 1.7 - 2;
  for (const auto& [column, low, high] :
       {std::tuple{2, least, 10 / 0.7 - 2}, {7, least, 10 / 0.7 - 2}, {12, least, 10 / 0.35 - 2},
        {17, least, 10 / 0.35 - 2}}) {
    EXPECT_NEAR(bounds.least_px(8, column), low, 1e-4) << column;
    EXPECT_NEAR(bounds.most_px(8, column), high, 1e-4) << column;
  }
  zones.targets[0].depth_m = zones.targets[3].depth_m = 2;
  EXPECT_NEAR(EvidenceOf(zones).bounds().most_px(8, 7), most, 1e-4);
}

TEST(ZoneEvidence, KnowsNoBoundsWhereAZoneSeesNothing) {
  TofZones zones = Zones(4);
  zones.targets[1] = {};
  const DisparityBounds bounds = EvidenceOf(zones).bounds();
  EXPECT_EQ(bounds.least_px(8, 7), -kInfinite);
  EXPECT_EQ(bounds.most_px(8, 7), kInfinite);
  EXPECT_LT(bounds.most_px(8, 2), kInfinite);
}

TEST(ZoneEvidence, TakesTheNearestReturnForABoundOnOneSide) {
  TofZones zones = Zones(2);
  zones.mode = ZoneMode::kNearest;
  const ZoneEvidence evidence = EvidenceOf(zones);
  EXPECT_EQ(evidence.bounds().least_px(8, 2), -kInfinite);
  EXPECT_NEAR(evidence.bounds().most_px(8, 2), 10 / 1.7 - 2, 1e-4);
  EXPECT_FALSE(evidence.SurfaceAt({2, 8})) << "no surface of a zone has to be there";
}

TEST(ZoneEvidence, HasNoUpperBoundWhereATargetMayBeAtTheCamera) {
  TofZones zones = Zones(2);
  zones.targets[0].sigma_m = 0.7F;
  EXPECT_EQ(EvidenceOf(zones).bounds().most_px(8, 2), kInfinite);
}

TEST(ZoneEvidence, FitsAPlaneToTheZonesAround) {
  TofZones zones = Zones(5, 4);
  // d = 4 + 0.05 (u − 50) − 0.02 (v − 40); zones are 20.2 px wide and 20.25 high.
  const auto plane = [](double u, double v) { return 4 + 0.05 * (u - 50) - 0.02 * (v - 40); };
  for (int v = 0; v < 4; ++v) {
    for (int u = 0; u < 5; ++u) {
      ZoneTarget& target = zones.targets[static_cast<size_t>(5 * v + u)];
      target.depth_m = static_cast<float>(DepthOf(plane(50 + 20.2 * (u - 2), 40 + 20.25 * (v - 1.5))));
      target.sigma_m = 0.001F;
    }
  }
  const ZoneEvidence evidence = EvidenceOf(zones);
  for (const cv::Point cell : {cv::Point(10, 8), cv::Point(6, 4), cv::Point(0, 0), cv::Point(19, 15)}) {
    const auto surface = evidence.SurfaceAt(cell);
    ASSERT_TRUE(surface) << cell;
    const cv::Point2d centre = Grid().CentrePx(cell);
    EXPECT_NEAR(surface->disparity_px, plane(centre.x, centre.y), 1e-3) << cell;
  }
}

TEST(ZoneEvidence, LeavesZonesOnAnotherSurfaceOutOfThePlane) {
  TofZones zones = Zones(5, 4);
  for (int v = 0; v < 4; ++v) zones.targets[static_cast<size_t>(5 * v + 4)].depth_m = 0.2F;  // d = 48
  const auto surface = EvidenceOf(zones).SurfaceAt({14, 8});  // in the fourth column of zones
  ASSERT_TRUE(surface);
  EXPECT_NEAR(surface->disparity_px, 3, 0.05);
}

TEST(ZoneEvidence, IsLessSureOfZonesThatSpread) {
  TofZones zones = Zones(1);
  // σ of d: (10 / 1.9 − 10 / 2.1) / 2 = 0.2506 px. One zone alone: twice that variance, for its mean
  // and for what it does not tell of the places in it.
  const auto surface = EvidenceOf(zones).SurfaceAt({10, 8});
  ASSERT_TRUE(surface);
  EXPECT_NEAR(surface->disparity_px, 3, 1e-4);
  const auto wide = [&] {
    zones.targets[0].sigma_m = 0.3F;
    return EvidenceOf(zones).SurfaceAt({10, 8});
  }();
  EXPECT_GT(wide->sigma_px, 2.9 * surface->sigma_px);
}

TEST(ZoneEvidence, FillsNoZoneOfSeveralOrDoubtfulTargets) {
  TofZones zones = Zones(2);
  zones.targets_per_zone = 2;
  zones.targets = {{2, 0.1F, TargetStatus::kValid}, {1, 0.1F, TargetStatus::kValid},
                   {2, 0.1F, TargetStatus::kValid}, {}};
  EXPECT_FALSE(EvidenceOf(zones).SurfaceAt({2, 8}));
  EXPECT_TRUE(EvidenceOf(zones).SurfaceAt({17, 8}));
  zones.targets[2].status = TargetStatus::kDoubtful;
  EXPECT_FALSE(EvidenceOf(zones).SurfaceAt({17, 8}));
}

TEST(ZoneEvidence, RefusesZonesThatAllLookAtOnePlace) {
  TofZones zones = Zones(16, 16);
  for (ZoneView& view : zones.views) view = {-0.5F, 0.5F, -0.4F, 0.4F};
  ZoneEvidence evidence;
  const Result<void> set = evidence.Set(zones, MakeRig().pair, Grid());
  ASSERT_FALSE(set);
  EXPECT_THAT(set.error().text, testing::HasSubstr("zones overlap: allowed are 64 zones"));
  EXPECT_TRUE(EvidenceOf(Zones(16, 16)).SurfaceAt({10, 8})) << "of a grid it takes as many";
}

TEST(ZoneEvidence, TakesZonesThatLookAnywhere) {
  TofZones zones = Zones(2);
  // Behind the pair, and beside it.
  zones.left_from_sensor.translation_m = {0, 0, -5};
  EXPECT_EQ(EvidenceOf(zones).bounds().most_px(8, 2), kInfinite);
  zones.left_from_sensor.translation_m = {1e300, 0, 0};
  EXPECT_EQ(EvidenceOf(zones).bounds().most_px(8, 2), kInfinite);
  zones = Zones(1);
  zones.views[0] = {-100, 100, -100, 100};
  EXPECT_NEAR(EvidenceOf(zones).bounds().most_px(8, 2), 10 / 1.7 - 2, 1e-4);
}

}  // namespace
}  // namespace sprout::refine
