#include "services/prior/triangulation/interpolation.h"

#include <gmock/gmock.h>

#include <optional>
#include <random>
#include <string>

#include "tests/common/testing/instruction_sets.h"

namespace sprout::prior {
namespace {

Seed MeshSeed(double u, double v, double disparity) {
  const auto left = static_cast<float>(u);
  return {.u = left, .v = static_cast<float>(v), .u_right = left - static_cast<float>(disparity)};
}

// On whole pixels, on halves, or anywhere; some of them outside the image.
std::vector<Seed> RandomSeeds(cv::Size size, int count, double grid, uint32_t seed) {
  std::mt19937 random(seed);
  const auto position = [&](int end) {
    const double x = (static_cast<double>(random() % 65536) / 65536 * 1.4 - 0.2) * end;
    return grid > 0 ? std::round(x / grid) * grid : x;
  };
  std::vector<Seed> seeds;
  for (int i = 0; i < count; ++i) {
    const double u = position(size.width);
    const double v = position(size.height);
    seeds.push_back(MeshSeed(u, v, static_cast<double>(random() % 60)));
  }
  return seeds;
}

std::vector<Plane> PlanesOf(const std::vector<Seed>& seeds) {
  std::vector<Plane> planes(seeds.size());
  std::transform(seeds.begin(), seeds.end(), planes.begin(), LevelPlane);
  return planes;
}

PriorMap InterpolateOnly(const std::vector<Seed>& seeds, cv::Size size) {
  PriorMap map(size);
  EXPECT_TRUE(Interpolate(PlanesOf(seeds), Triangulate(seeds).triangles, 0.5, map).has_value());
  return map;
}

// Twice the area of a triangle; its sign says which way round it runs.
double Area(const Plane& a, const Plane& b, double u, double v) {
  return (double{b.u} - a.u) * (v - a.v) - (double{b.v} - a.v) * (u - a.u);
}

// By barycentric coordinates; nothing when the pixel lies outside the triangle.
std::optional<double> ValueIn(const Corners& t, double u, double v) {
  const double area = Area(t[0], t[1], t[2].u, t[2].v);
  const double w0 = Area(t[1], t[2], u, v) / area;
  const double w1 = Area(t[2], t[0], u, v) / area;
  const double w2 = Area(t[0], t[1], u, v) / area;
  if (std::min({w0, w1, w2}) < 0) return std::nullopt;
  return w0 * t[0].disparity + w1 * t[1].disparity + w2 * t[2].disparity;
}

TEST(TrianglesByBand, HasTrianglesInTheBandsThatTheyReach) {
  std::vector<Plane> planes;
  for (const float v : {-1e30F, -5.F, 10.F, 63.F, 64.F, 127.9F, 128.F, 1e30F}) {
    planes.push_back({.v = v});
  }
  const std::vector<SeedTriangle> triangles = {{2, 3, 2}, {3, 4, 2}, {5, 4, 4}, {0, 7, 3},
                                               {0, 1, 1}, {6, 7, 7}, {6, 5, 5}};
  const TrianglesByBand bands(
      planes, triangles.size(), [&](size_t i) { return triangles[i]; }, 150);
  ASSERT_EQ(bands.size(), 3);
  EXPECT_EQ(bands.RowsOf(2), cv::Range(128, 150));
  EXPECT_THAT(bands.TrianglesOf(0), testing::IsSupersetOf({0, 1, 3}));
  EXPECT_THAT(bands.TrianglesOf(1), testing::ElementsAre(1, 2, 3, 6));
  EXPECT_THAT(bands.TrianglesOf(2), testing::ElementsAre(3, 5, 6));
}

TEST(ForEachRun, HasEveryPixelOfATriangleAndHardlyAnyOther) {
  const cv::Size size(37, 23);
  for (const double grid : {0.0, 0.5, 1.0}) {
    for (uint32_t seed = 0; seed < 200; ++seed) {
      const std::vector<Plane> planes = PlanesOf(RandomSeeds(size, 3, grid, seed));
      const Corners corners = CornersOf(planes, {0, 1, 2});
      if (Area(corners[0], corners[1], corners[2].u, corners[2].v) == 0) continue;
      cv::Mat1b painted(size, uint8_t{0});
      for (const cv::Range& rows : {cv::Range(0, 9), cv::Range(9, size.height)}) {
        ForEachRun(corners, size.width, rows, [&](int v, int begin, int end) {
          ASSERT_TRUE(rows.start <= v && v < rows.end && 0 <= begin && end <= size.width);
          for (int u = begin; u < end; ++u) painted(v, u) = 1;
        });
      }
      int extra = 0;
      for (int v = 0; v < size.height; ++v) {
        for (int u = 0; u < size.width; ++u) {
          const bool inside = ValueIn(corners, u, v).has_value();
          ASSERT_LE(inside, painted(v, u)) << u << ", " << v << " of triangle " << seed;
          extra += painted(v, u) - (inside ? 1 : 0);
        }
      }
      EXPECT_LE(extra, 2) << "triangle " << seed;
    }
  }
}

TEST(Interpolation, EqualsBruteForceWithEveryInstructionSet) {
  const cv::Size size(151, 75);
  for (uint32_t seed = 0; seed < 9; ++seed) {
    const double grid = seed % 3 * 0.5;
    const std::vector<Seed> seeds = RandomSeeds(size, 5 + 40 * static_cast<int>(seed), grid, seed);
    const std::vector<Plane> planes = PlanesOf(seeds);
    const std::vector<SeedTriangle> triangles = Triangulate(seeds).triangles;
    std::optional<PriorMap> first;
    ForEachInstructionSet([&](const std::string& name) {
      PriorMap map(size);
      ASSERT_TRUE(Interpolate(planes, triangles, 0.5, map).has_value());
      if (!first) first = map;
      EXPECT_EQ(cv::norm(map.disparity.counts(), first->disparity.counts(), cv::NORM_INF), 0)
          << name << ", seed " << seed;
      EXPECT_EQ(cv::norm(map.sigma, first->sigma, cv::NORM_INF), 0) << name << ", seed " << seed;
    });
    int inside = 0;
    for (const SeedTriangle& triangle : triangles) {
      for (int v = 0; v < size.height; ++v) {
        for (int u = 0; u < size.width; ++u) {
          const auto expected = ValueIn(CornersOf(planes, triangle), u, v);
          if (!expected) continue;
          ++inside;
          // Half a count of rounding; slivers lose a little more to their tiny area.
          EXPECT_NEAR(first->disparity.Px(u, v), *expected, 0.55 / DisparityImage::kCountsPerPixel)
              << "seed " << seed << " at (" << u << ", " << v << ")";
          EXPECT_NE(first->sigma(v, u), kMaxSigmaCounts);
        }
      }
    }
    EXPECT_GT(inside, 1000);
  }
}

TEST(Interpolation, ReproducesAPlaneExactly) {
  const auto plane = [](double u, double v) { return 10 + u / 8 + v / 16; };
  std::vector<Seed> seeds;
  for (int v = 0; v < 48; v += 8) {
    for (int u = 0; u < 64; u += 8) seeds.push_back(MeshSeed(u, v, plane(u, v)));
  }
  const PriorMap map = InterpolateOnly(seeds, {64, 48});
  for (int v = 0; v <= 40; ++v) {
    for (int u = 0; u <= 56; ++u) {
      EXPECT_EQ(map.disparity.Px(u, v), static_cast<float>(plane(u, v)));
    }
  }
}

TEST(Interpolation, TakesTheNearestHullValueOutsideTheHull) {
  const PriorMap map = InterpolateOnly(
      {MeshSeed(20, 10, 4), MeshSeed(40, 10, 8), MeshSeed(40, 30, 8), MeshSeed(20, 30, 4)},
      {64, 48});
  EXPECT_EQ(map.disparity.CountValid(), 64 * 48);
  EXPECT_EQ(map.disparity.Px(0, 20), 4);
  EXPECT_EQ(map.disparity.Px(0, 0), 4);
  EXPECT_EQ(map.disparity.Px(30, 0), 6);
  EXPECT_EQ(map.disparity.Px(30, 47), 6);
  EXPECT_EQ(map.disparity.Px(63, 47), 8);
}

TEST(Interpolation, TakesTheNearestPixelOfTheRowOutsideAnyHull) {
  const cv::Size size(61, 47);
  for (uint32_t seed = 0; seed < 30; ++seed) {
    std::vector<Seed> seeds = RandomSeeds({31, 21}, 4 + static_cast<int>(seed), 0, seed);
    for (Seed& moved : seeds) {
      moved.u += 16;
      moved.v += 13;
      moved.u_right += 16;
    }
    const PriorMap map = InterpolateOnly(seeds, size);
    const cv::Mat1s& counts = map.disparity.counts();
    std::vector<int> rows;  // with painted pixels
    for (int v = 0; v < size.height; ++v) {
      std::vector<int> painted;
      for (int u = 0; u < size.width; ++u) {
        if (map.sigma(v, u) != kMaxSigmaCounts) painted.push_back(u);
      }
      if (painted.empty()) continue;
      rows.push_back(v);
      for (int u = 0; u < size.width; ++u) {
        ASSERT_EQ(counts(v, u), counts(v, std::clamp(u, painted.front(), painted.back())));
      }
    }
    ASSERT_FALSE(rows.empty());
    for (int v = 0; v < size.height; ++v) {
      const int nearest = std::clamp(v, rows.front(), rows.back());
      ASSERT_EQ(cv::countNonZero(counts.row(v) != counts.row(nearest)), 0) << v;
    }
  }
}

TEST(Interpolation, SaysWhyThereIsNone) {
  PriorMap map(cv::Size(64, 48));
  const std::vector<Seed> between = {MeshSeed(1.1, 1.1, 1), MeshSeed(1.2, 1.1, 1),
                                     MeshSeed(1.1, 1.2, 1)};
  const auto done = Interpolate(PlanesOf(between), Triangulate(between).triangles, 0.5, map);
  EXPECT_THAT(done.error().text, testing::HasSubstr("cover no pixel"));
}

TEST(Interpolation, KeepsToTheRangeOfDisparities) {
  for (const double px : {-3.0, 2000.0}) {
    const PriorMap map =
        InterpolateOnly({MeshSeed(0, 0, px), MeshSeed(9, 0, px), MeshSeed(0, 9, px)}, {9, 9});
    EXPECT_EQ(map.disparity.Px(2, 2), px < 0 ? 0 : DisparityImage::kMaxPx);
  }
}

TEST(Interpolation, SurvivesSeedsOutsideTheImage) {
  const PriorMap map = InterpolateOnly(
      {MeshSeed(-500, -500, 3), MeshSeed(5000, -100, 3), MeshSeed(100, 9000, 3)}, {64, 48});
  EXPECT_EQ(map.disparity.CountValid(), 64 * 48);
  EXPECT_EQ(map.disparity.Px(30, 30), 3);
}

// The standard deviation.

constexpr int kSidePx = 40;

// Two triangles that make a square of kSidePx px with its corners on whole pixels.
struct SquareMap {
  std::vector<Plane> planes{{.u = 0, .v = 0, .disparity = 10, .sigma_px = 0.5F},
                            {.u = kSidePx, .v = 0, .disparity = 10, .sigma_px = 0.5F},
                            {.u = 0, .v = kSidePx, .disparity = 10, .sigma_px = 0.5F},
                            {.u = kSidePx, .v = kSidePx, .disparity = 10, .sigma_px = 0.5F}};

  cv::Mat1b Sigma() const {
    PriorMap map(cv::Size(60, 60));
    EXPECT_TRUE(Interpolate(planes, std::vector<SeedTriangle>{{0, 1, 2}, {1, 3, 2}}, 0.5, map));
    return map.sigma;
  }
};

TEST(Sigma, IsThatOfSeedsThatAgree) {
  SquareMap square;
  EXPECT_EQ(square.Sigma()(20, 20), SigmaToCounts(0.5));
  for (Plane& plane : square.planes) {  // one slant
    plane.per_column = 0.25F;
    plane.disparity += 0.25F * plane.u;
  }
  EXPECT_EQ(square.Sigma()(10, 10), SigmaToCounts(0.5));
}

TEST(Sigma, TakesTheMeanVarianceOfTheCorners) {
  SquareMap square;
  square.planes[0].sigma_px = 3;
  const cv::Mat1b sigma = square.Sigma();
  EXPECT_EQ(sigma(5, 5), SigmaToCounts(std::sqrt((9 + 0.25 + 0.25) / 3)));
  EXPECT_EQ(sigma(35, 35), SigmaToCounts(0.5));
}

TEST(Sigma, GrowsWherePlanesDoNotLeadIntoEachOther) {
  SquareMap square;
  for (Plane& plane : square.planes) plane.sigma_px = 0.05F;
  square.planes[0].per_column = 0.036F;  // 0.48 px off at the centroid, 40/3 px away
  EXPECT_EQ(square.Sigma()(5, 5), SigmaToCounts(std::sqrt(0.0025 + 0.48 * 0.48 / 3)));
}

TEST(Sigma, DoesNotCountTheStepOfADepthEdge) {
  SquareMap square;
  square.planes[0].disparity = 50;
  EXPECT_EQ(square.Sigma()(5, 5), SigmaToCounts(0.5));
}

TEST(Sigma, KnowsNothingOutsideTheTriangles) {
  const cv::Mat1b sigma = SquareMap().Sigma();
  EXPECT_EQ(sigma(50, 20), kMaxSigmaCounts);
  EXPECT_EQ(sigma(20, 50), kMaxSigmaCounts);
}

}  // namespace
}  // namespace sprout::prior
