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

// In the left camera's place, its field of view; `columns` × `rows` zones with a target at 2 m, d
// = 3.
TofZones Zones(int columns, int rows = 1) {
  TofZones zones{
      .columns = columns, .rows = rows, .left_from_sensor = {}, .views = {}, .targets = {}};
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
  EXPECT_TRUE(evidence.most_px().empty());
  EXPECT_FALSE(evidence.SurfaceAt({0, 0}));
}

TEST(ZoneEvidence, BoundsDisparitiesByTheZonesWithinReach) {
  TofZones zones = Zones(4);
  zones.targets[0].depth_m = 1;
  zones.targets[3] = {0.5F, 0.05F, TargetStatus::kDoubtful};
  const cv::Mat1f most_px = EvidenceOf(zones).most_px();
  ASSERT_EQ(most_px.size(), cv::Size(20, 16));
  // By hand: 10 / (z − 3 σ) − 2; a zone has five columns of cells.
  for (const auto& [column, most] :
       {std::pair{2, 10 / 0.7 - 2}, {7, 10 / 0.7 - 2}, {12, 10 / 0.35 - 2}, {17, 10 / 0.35 - 2}}) {
    EXPECT_NEAR(most_px(8, column), most, 1e-4) << column;
  }
  zones.targets[0].depth_m = 2;
  EXPECT_NEAR(EvidenceOf(zones).most_px()(8, 7), 10 / 1.7 - 2, 1e-4);
}

TEST(ZoneEvidence, KnowsNoBoundWhereAZoneSeesNothing) {
  TofZones zones = Zones(4);
  zones.targets[1] = {};
  const cv::Mat1f most_px = EvidenceOf(zones).most_px();
  EXPECT_EQ(most_px(8, 7), kInfinite);
  EXPECT_NEAR(most_px(8, 2), 10 / 1.7 - 2, 1e-4);
}

TEST(ZoneEvidence, TakesANearestReturnForABoundOnly) {
  TofZones zones = Zones(2);
  zones.mode = ZoneMode::kNearest;
  const ZoneEvidence evidence = EvidenceOf(zones);
  EXPECT_NEAR(evidence.most_px()(8, 2), 10 / 1.7 - 2, 1e-4);
  EXPECT_FALSE(evidence.SurfaceAt({2, 8})) << "most of the zone may lie behind";
}

TEST(ZoneEvidence, KnowsNoBoundWhereATargetMayBeAtTheCamera) {
  TofZones zones = Zones(2);
  zones.targets[0].sigma_m = 0.7F;
  EXPECT_EQ(EvidenceOf(zones).most_px()(8, 2), kInfinite);
}

TEST(ZoneEvidence, FitsAPlaneToTheZonesAround) {
  TofZones zones = Zones(5, 4);
  // d = 4 + 0.05 (u − 50) − 0.02 (v − 40); zones are 20.2 px wide and 20.25 high.
  const auto plane = [](double u, double v) { return 4 + 0.05 * (u - 50) - 0.02 * (v - 40); };
  for (int v = 0; v < 4; ++v) {
    for (int u = 0; u < 5; ++u) {
      ZoneTarget& target = zones.targets[static_cast<size_t>(5 * v + u)];
      target.depth_m =
          static_cast<float>(DepthOf(plane(50 + 20.2 * (u - 2), 40 + 20.25 * (v - 1.5))));
      target.sigma_m = 0.001F;
    }
  }
  const ZoneEvidence evidence = EvidenceOf(zones);
  for (const cv::Point cell :
       {cv::Point(10, 8), cv::Point(6, 4), cv::Point(0, 0), cv::Point(19, 15)}) {
    const auto surface = evidence.SurfaceAt(cell);
    ASSERT_TRUE(surface) << cell;
    const cv::Point2d centre = Grid().CentrePx(cell);
    EXPECT_NEAR(surface->disparity_px, plane(centre.x, centre.y), 1e-3) << cell;
  }
}

TEST(ZoneEvidence, LeavesZonesOnAnotherSurfaceOutOfThePlane) {
  TofZones zones = Zones(5, 4);
  for (int v = 0; v < 4; ++v)
    zones.targets[static_cast<size_t>(5 * v + 4)].depth_m = 0.2F;  // d = 48
  const auto surface = EvidenceOf(zones).SurfaceAt({14, 8});       // in the fourth column of zones
  ASSERT_TRUE(surface);
  EXPECT_NEAR(surface->disparity_px, 3, 0.05);
}

TEST(ZoneEvidence, IsAsSureAsItsZonesAndLessSoBeside) {
  TofZones zones = Zones(5, 4);
  // σ of d of each zone: (10 / 1.9 − 10 / 2.1) / 2 = 0.2506 px. In the middle of nine of them the
  // plane is the mean: σ² (1 + 1 / 9).
  const double sigma_px = (10 / 1.9 - 10 / 2.1) / 2;
  const auto at = [&](cv::Point cell) { return *EvidenceOf(zones).SurfaceAt(cell); };
  EXPECT_NEAR(at({10, 6}).disparity_px, 3, 1e-4);
  // The cell's centre is 2.0 and 2.4 px off the zone's; slopes are known to σ / (√6 · 20.2 px).
  EXPECT_NEAR(at({10, 6}).sigma_px, sigma_px * std::sqrt(1 + 1 / 9.0), 0.003);
  EXPECT_GT(at({0, 0}).sigma_px, at({10, 6}).sigma_px);
  for (ZoneTarget& target : zones.targets) target.sigma_m = 0.3F;
  EXPECT_GT(at({10, 6}).sigma_px, 2.9 * sigma_px * std::sqrt(1 + 1 / 9.0));
}

// Seeds at d = 3 on both sides of cell (10, 8).
std::vector<Seed> SeedsAround(float sigma_px) {
  std::vector<Seed> seeds;
  for (const float v : {12.F, 27.F, 42.F, 57.F, 72.F}) {
    for (const float u : {12.F, 32.F, 72.F, 92.F}) {
      seeds.push_back({.u = u, .v = v, .u_right = u - 3, .sigma_px = sigma_px});
    }
  }
  return seeds;
}

TEST(ZoneEvidence, AddsInformationWhereSurerSeedsDoNotSayTheSame) {
  const auto is_news = [](double disparity_px, double sigma_px, float seed_sigma_px) {
    const std::vector<Seed> seeds = SeedsAround(seed_sigma_px);
    PointSurface surface;
    surface.Set(seeds, Grid());
    return AddsInformation({disparity_px, sigma_px}, surface, {10, 8});
  };
  EXPECT_TRUE(is_news(6.1, 1, 5)) << "3 σ off, and 4 times as sure";
  EXPECT_FALSE(is_news(5.9, 1, 5)) << "agrees with the seeds";
  EXPECT_TRUE(is_news(-0.1, 1, 5));
  EXPECT_FALSE(is_news(6.1, 1, 3.5F)) << "the seeds are nearly as sure";
  PointSurface none;
  none.Set({}, Grid());
  EXPECT_TRUE(AddsInformation({3, 100}, none, {10, 8})) << "nothing else is known";
}

TEST(ZoneEvidence, FillsNoZoneOfSeveralOrDoubtfulTargets) {
  TofZones zones = Zones(2);
  zones.targets_per_zone = 2;
  zones.targets = {{2, 0.1F, TargetStatus::kValid},
                   {1, 0.1F, TargetStatus::kValid},
                   {2, 0.1F, TargetStatus::kValid},
                   {}};
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
  EXPECT_EQ(EvidenceOf(zones).most_px()(8, 2), kInfinite);
  zones.left_from_sensor.translation_m = {1e300, 0, 0};
  EXPECT_EQ(EvidenceOf(zones).most_px()(8, 2), kInfinite);
  zones = Zones(1);
  zones.views[0] = {-100, 100, -100, 100};
  EXPECT_NEAR(EvidenceOf(zones).most_px()(8, 2), 10 / 1.7 - 2, 1e-4);
}

}  // namespace
}  // namespace sprout::refine
