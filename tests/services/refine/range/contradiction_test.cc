#include "services/refine/range/contradiction.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace sprout::refine {
namespace {

const cv::Size kPicture(600, 400);

Seed MatchAt(double u, double v, double disparity) {
  return {.u = static_cast<float>(u),
          .v = static_cast<float>(v),
          .u_right = static_cast<float>(u - disparity)};
}

// Points, and a pair of images, of a wall at 20 px.
struct FlatScene {
  cv::Mat1b left{kPicture}, right{kPicture};
  std::vector<ProjectedPoint> points;

  FlatScene() {
    cv::RNG(3).fill(left, cv::RNG::UNIFORM, 0, 256);
    left.copyTo(right);
    left.colRange(20, kPicture.width).copyTo(right.colRange(0, kPicture.width - 20));
    for (int v = 0; v < kPicture.height / 5; ++v) {
      for (int u = 0; u < kPicture.width / 5; ++u) {
        points.push_back({u, v, MatchAt(5 * u + 2, 5 * v + 2, 20)});
      }
    }
  }

  void SetDisparity(const cv::Rect& pixels, float disparity) {
    for (ProjectedPoint& point : points) {
      if (!pixels.contains({point.tof_u, point.tof_v})) continue;
      point.seed.u_right = point.seed.u - disparity;
    }
  }

  // @param known  where there are matches.
  // @param cells  null: it is not asked how far the points are off.
  Contradiction Find(const cv::Rect& known, double disparity = 20, const CellGrid* cells = nullptr,
                     double unexplained = RangeRules::kUnexplained) const {
    std::vector<Seed> matches;
    for (int v = 4; v < kPicture.height - 4; v += 8) {
      for (int u = 44; u < kPicture.width - 4; u += 8) {
        if (!known.contains({u, v})) continue;
        matches.push_back(MatchAt(u, v, disparity));
        matches.back().sigma_px = 0.25F;
      }
    }
    return FindContradicted(left, right, {points, points, {5, 5}, kPicture}, matches, 2, cells,
                            unexplained);
  }
};

TEST(Contradiction, IsOfTheSurfaceThatIsWrong) {
  FlatScene wall;
  const cv::Rect all({}, kPicture);
  EXPECT_EQ(wall.Find(all).share, 0);
  const cv::Rect block(40, 20, 30, 30);
  wall.SetDisparity(block, 33);
  // Where a block has matches in one place only, these stand for all of it.
  for (const cv::Rect& known : {all, cv::Rect(0, 0, 250, 150)}) {
    const Contradiction found = wall.Find(known);
    EXPECT_GT(found.share, 0.02);
    for (size_t i = 0; i < wall.points.size(); ++i) {
      const cv::Point pixel(wall.points[i].tof_u, wall.points[i].tof_v);
      ASSERT_EQ(found.points[i] != 0, block.contains(pixel)) << pixel;
    }
  }
}

// As of a wall without texture: what stereo matches there may be wrong, too.
TEST(Contradiction, IsNotOfASurfaceWithHardlyAnyMatches) {
  FlatScene wall;
  const cv::Rect seen(20, 20, 30, 30), plain(70, 20, 40, 40);
  wall.SetDisparity(seen, 33);
  wall.SetDisparity(plain, 33);
  std::vector<Seed> matches;
  for (int v = 4; v < kPicture.height - 4; v += 8) {
    for (int u = 44; u < kPicture.width - 4; u += 8) {
      if (plain.contains({u / 5, v / 5}) && (u % 5 != 0 || v % 5 != 0)) continue;
      matches.push_back(MatchAt(u, v, 20));
    }
  }
  const Contradiction found = FindContradicted(
      wall.left, wall.right, {wall.points, wall.points, {5, 5}, kPicture}, matches, 2);
  ASSERT_EQ(found.points.size(), wall.points.size());
  for (size_t i = 0; i < wall.points.size(); ++i) {
    const cv::Point pixel(wall.points[i].tof_u, wall.points[i].tof_v);
    ASSERT_EQ(found.points[i] != 0, seen.contains(pixel)) << pixel;
  }
}

// Errors that agree to 2 px are measured, unless the points claim that much themselves.
TEST(Contradiction, TellsWhatPointsAreOffByWhereTheyClaimTooLittle) {
  const CellGrid cells(8, kPicture);
  const cv::Rect all({}, kPicture);
  FlatScene wall;
  EXPECT_TRUE(wall.Find(all, 20, &cells).sigma_px.empty());
  const cv::Rect block(20, 10, 60, 60);
  wall.SetDisparity(block, 21.5F);
  EXPECT_TRUE(wall.Find(all).sigma_px.empty());  // not asked
  const Contradiction found = wall.Find(all, 20, &cells);
  EXPECT_TRUE(found.points.empty());
  ASSERT_EQ(found.sigma_px.size(), wall.points.size());
  const cv::Rect inside(26, 16, 48, 48), beside(14, 4, 72, 72);
  for (size_t i = 0; i < wall.points.size(); ++i) {
    const cv::Point pixel(wall.points[i].tof_u, wall.points[i].tof_v);
    if (inside.contains(pixel)) {
      ASSERT_NEAR(found.sigma_px[i], 1.48, 0.02) << pixel;
    } else if (pixel.x > 8 && !beside.contains(pixel)) {  // further left no match is near
      ASSERT_EQ(found.sigma_px[i], 0) << pixel;
    }
  }
  for (ProjectedPoint& point : wall.points) point.seed.sigma_px = 0.75F;
  EXPECT_TRUE(wall.Find(all, 20, &cells).sigma_px.empty());
  EXPECT_FALSE(wall.Find(all, 20, &cells, /*unexplained=*/1).sigma_px.empty());
}

// Where nothing is to be seen, stereo may be wrong as well.
TEST(Contradiction, NeedsImagesThatPreferTheMatches) {
  FlatScene wall;
  wall.left = 90;
  wall.right = 90;
  const Contradiction found = wall.Find(cv::Rect({}, kPicture), 33);
  EXPECT_EQ(found.share, 0);
  EXPECT_EQ(std::ranges::count(found.points, 1), 0);
}

// Points are compared with matches at their own places, and count alike.
TEST(ShareAgainst, IsThatOfThePointsThatTheImagesContradict) {
  FlatScene wall;
  std::vector<Seed> matches;
  for (int v = 4; v < kPicture.height - 4; v += 8) {
    for (int u = 44; u < kPicture.width - 4; u += 8) matches.push_back(MatchAt(u, v, 20));
  }
  const auto share = [&] { return ShareAgainst(wall.left, wall.right, wall.points, matches, 8); };
  EXPECT_EQ(share(), 0);
  wall.SetDisparity({60, 0, 60, 80}, 33);
  EXPECT_NEAR(share(), 60 / 112.0, 0.02);
  wall.SetDisparity({60, 0, 60, 80}, 21);
  EXPECT_EQ(share(), 0);
  wall.SetDisparity({0, 0, 120, 80}, 33);
  matches.resize(8);  // beside fewer than 50 points
  EXPECT_EQ(share(), 0);
}

// Images of two scenes may prefer one place to another, here by brightness.
TEST(ShareAgainst, NeedsMatchesWhoseWindowsAreAlike) {
  FlatScene wall;
  wall.SetDisparity({0, 0, 120, 80}, 33);
  std::vector<Seed> matches;
  for (int v = 4; v < kPicture.height - 4; v += 8) matches.push_back(MatchAt(226, v, 20));
  const auto share = [&] { return ShareAgainst(wall.left, wall.right, wall.points, matches, 8); };
  EXPECT_GT(share(), 0.9);
  cv::RNG(8).fill(wall.right, cv::RNG::UNIFORM, 0, 256);
  wall.right.colRange(0, 198) = 0;
  EXPECT_EQ(share(), 0);
}

TEST(ShareAgainst, NeedsImagesThatPreferTheMatches) {
  FlatScene wall;
  wall.left = 90;
  wall.right = 90;
  wall.SetDisparity({0, 0, 120, 80}, 33);
  std::vector<Seed> matches;
  for (int u = 44; u < kPicture.width - 4; ++u) matches.push_back(MatchAt(u, 200, 20));
  EXPECT_EQ(ShareAgainst(wall.left, wall.right, wall.points, matches, 8), 0);
}

}  // namespace
}  // namespace sprout::refine
