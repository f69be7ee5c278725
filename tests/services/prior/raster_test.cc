// Triangles to pixels: none between two triangles is missed, in the image and at its border.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <random>
#include <tuple>
#include <vector>

#include "services/prior/interpolation.h"
#include "services/prior/triangle_raster.h"

namespace sprout {
namespace {

// On whole pixels, on halves, or anywhere; some of them outside the image.
std::vector<Seed> RandomSeeds(cv::Size size, int count, double grid, uint32_t seed) {
  std::mt19937 random(seed);
  const auto position = [&](int end) {
    const double x = (static_cast<double>(random() % 65536) / 65536 * 1.4 - 0.2) * end;
    return static_cast<float>(grid > 0 ? std::round(x / grid) * grid : x);
  };
  std::vector<Seed> seeds;
  for (int i = 0; i < count; ++i) {
    const float u = position(size.width);
    const float v = position(size.height);
    seeds.push_back({u, v, u - static_cast<float>(random() % 60)});
  }
  return seeds;
}

// Twice the area of a triangle, counted as positive where its corners run counter-clockwise.
double Area(const Seed& a, const Seed& b, double u, double v) {
  return (double{b.u} - a.u) * (v - a.v) - (double{b.v} - a.v) * (u - a.u);
}

bool Contains(const Seed& a, const Seed& b, const Seed& c, int u, int v) {
  const double ab = Area(a, b, u, v);
  const double bc = Area(b, c, u, v);
  const double ca = Area(c, a, u, v);
  return (ab >= 0 && bc >= 0 && ca >= 0) || (ab <= 0 && bc <= 0 && ca <= 0);
}

TEST(TriangleRaster, HasEveryPixelOfATriangleAndHardlyAnyOther) {
  const cv::Size size(37, 23);
  for (const double grid : {0.0, 0.5, 1.0}) {
    for (uint32_t seed = 0; seed < 200; ++seed) {
      const std::vector<Seed> corners = RandomSeeds(size, 3, grid, seed);
      const auto& [a, b, c] = std::tie(corners[0], corners[1], corners[2]);
      if (Area(a, b, c.u, c.v) == 0) continue;  // no triangulation has such
      cv::Mat1b painted(size, uint8_t{0});
      for (const cv::Range& rows : {cv::Range(0, 9), cv::Range(9, size.height)}) {
        if (!ReachOf(a, b, c).Meets(rows)) continue;
        const TriangleRaster raster(a, b, c, size.width, rows);
        for (int v = raster.first_row(); v < raster.end_row(); ++v) {
          const PixelRun run = raster.Run(v);
          for (int u = run.begin; u < run.end; ++u) painted(run.v, u) = 1;
        }
      }
      int extra = 0;
      for (int v = 0; v < size.height; ++v) {
        for (int u = 0; u < size.width; ++u) {
          const bool inside = Contains(a, b, c, u, v);
          ASSERT_LE(inside, painted(v, u)) << u << ", " << v << " of triangle " << seed;
          extra += painted(v, u) - (inside ? 1 : 0);
        }
      }
      EXPECT_LE(extra, 2) << "triangle " << seed;
    }
  }
}

TEST(Prior, TakesTheNearestPixelOfAnyHull) {
  const cv::Size size(61, 47);
  for (uint32_t seed = 0; seed < 30; ++seed) {
    std::vector<Seed> seeds = RandomSeeds({31, 21}, 4 + static_cast<int>(seed), 0, seed);
    for (Seed& moved : seeds) {
      moved.u += 16;
      moved.v += 13;
      moved.u_right += 16;
    }
    const auto triangles = TriangulateSeeds(seeds);
    const auto prior = InterpolateSeeds(seeds, triangles, size);
    ASSERT_TRUE(prior.has_value());
    std::vector<cv::Point> hull;
    const auto seed_of = [&](int i) { return seeds[static_cast<size_t>(i)]; };
    for (const auto& [a, b, c] : triangles) {
      const TriangleRaster raster(seed_of(a), seed_of(b), seed_of(c), size.width, {0, size.height});
      for (int v = raster.first_row(); v < raster.end_row(); ++v) {
        const PixelRun run = raster.Run(v);
        for (int u = run.begin; u < run.end; ++u) hull.emplace_back(u, run.v);
      }
    }
    for (int v = 0; v < size.height; ++v) {
      for (int u = 0; u < size.width; ++u) {
        double nearest = 1e9;
        double taken = 1e9;  // nearest one of the value that the pixel has
        for (const cv::Point& p : hull) {
          const double distance = std::hypot(p.x - u, p.y - v);
          nearest = std::min(nearest, distance);
          if (prior->counts()(p) == prior->counts()(v, u)) taken = std::min(taken, distance);
        }
        EXPECT_LE(taken, nearest + 1) << u << ", " << v << " with seed " << seed;
      }
    }
  }
}

TEST(Prior, IsTheSameInMemoryThatWasUsedBefore) {
  const cv::Size size(40, 30);
  const std::vector<Seed> seeds = RandomSeeds(size, 30, 0, 5);
  const auto triangles = TriangulateSeeds(seeds);
  const auto expected = InterpolateSeeds(seeds, triangles, size);
  const DisparityImage used(cv::Mat1s(size, int16_t{77}));
  const auto again = InterpolateSeeds(seeds, triangles, size, used);
  EXPECT_EQ(again->counts().data, used.counts().data);
  EXPECT_EQ(cv::countNonZero(again->counts() != expected->counts()), 0);
}

}  // namespace
}  // namespace sprout
