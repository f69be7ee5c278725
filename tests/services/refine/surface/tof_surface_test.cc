#include "services/refine/surface/tof_surface.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

namespace sprout::refine {
namespace {

// A ToF camera of 12×10 pixels; its columns and rows lie 8 px apart in the images.
Rig SomeRig() {
  Rig rig;
  rig.pair.width = 200;
  rig.pair.height = 120;
  rig.pair.focal_px = 80;
  rig.tof.width = 12;
  rig.tof.height = 10;
  rig.tof.fx = rig.tof.fy = 10;
  return rig;
}

// Point of ToF pixel (i, j) with a disparity, as a camera between the colour cameras sees it: the
// nearer, the further right in the left image and the further left in the right one.
ProjectedPoint Point(int i, int j, float disparity) {
  const float middle = 60 + 8 * static_cast<float>(i);
  return {i, j, {middle + disparity / 2, 20 + 8 * static_cast<float>(j), middle - disparity / 2}};
}

std::vector<ProjectedPoint> Points(const std::function<float(float i, float j)>& disparity) {
  std::vector<ProjectedPoint> points;
  for (int j = 0; j < 10; ++j) {
    for (int i = 0; i < 12; ++i)
      points.push_back(Point(i, j, disparity(static_cast<float>(i), static_cast<float>(j))));
  }
  return points;
}

// ToF columns with a point in row 5 that is loose, or hidden from either camera.
template <typename Fate>
std::vector<int> Columns(const std::vector<Fate>& fates) {
  std::vector<int> columns;
  for (int i = 0; i < 12; ++i) {
    if (fates[static_cast<size_t>(5 * 12 + i)] != Fate()) columns.push_back(i);
  }
  return columns;
}

// Hidden points of row 5. Images of one colour agree with everything, so where points lie decides.
std::vector<int> HiddenColumns(const std::vector<ProjectedPoint>& points, double core = 0.75,
                               double tolerance_px = 1) {
  const cv::Mat1b grey(120, 200, uint8_t{100});
  return Columns(TofSurface(SomeRig(), points)
                     .FindHidden(points, points.size(), grey, grey,
                                 {.core = core, .reach = 0.9, .tolerance_px = tolerance_px}));
}

std::vector<uint8_t> FindLoose(const std::vector<ProjectedPoint>& points, double tolerance_px) {
  const TofSurface surface(SomeRig(), points);
  std::vector<uint8_t> loose;
  for (const ProjectedPoint& point : points)
    loose.push_back(surface.IsIsolated(point, tolerance_px));
  return loose;
}

int CountLoose(const std::vector<ProjectedPoint>& points, double tolerance_px = 2) {
  const std::vector<uint8_t> loose = FindLoose(points, tolerance_px);
  return static_cast<int>(std::count(loose.begin(), loose.end(), 1));
}

TEST(TofSurface, HidesWhatABoardCoversInEitherImage) {
  // The board moves by 8 px against the wall, a ToF pixel: right in the left image, where it falls
  // onto the column after it, and left in the right image, onto the column before it.
  const auto points = Points([](float i, float) { return i >= 4 && i <= 7 ? 26.f : 10.f; });
  EXPECT_THAT(HiddenColumns(points), testing::ElementsAre(3, 8));
}

TEST(TofSurface, TellsWhichCameraDoesNotSeeAPoint) {
  const auto points = Points([](float i, float) { return i >= 4 && i <= 7 ? 26.f : 10.f; });
  const cv::Mat1b grey(120, 200, uint8_t{100});
  TofSurface surface(SomeRig(), points);
  const HiddenRule rule{.core = 0.75, .reach = 0.9, .tolerance_px = 1};
  const auto in_row_5 = [&](size_t in_both, size_t column) {
    return surface.FindHidden(points, in_both, grey, grey, rule)[5 * 12 + column];
  };
  EXPECT_EQ(in_row_5(points.size(), 3), (Hidden{.from_left = false, .from_right = true}));
  EXPECT_EQ(in_row_5(points.size(), 8), (Hidden{.from_left = true, .from_right = false}));
  // Of rows that lie outside the right image nothing is hidden there.
  EXPECT_EQ(in_row_5(5 * 12, 3), Hidden());
  EXPECT_EQ(in_row_5(5 * 12, 8), (Hidden{.from_left = true, .from_right = false}));
}

TEST(TofSurface, HidesNothingOnAPlane) {
  EXPECT_THAT(HiddenColumns(Points([](float, float) { return 10.f; })), testing::IsEmpty());
}

TEST(TofSurface, HidesNothingOnASlant) {
  // 3 px a ToF column and 2 px a row: with a window and no slant, all would hide their neighbours.
  const auto points = Points([](float i, float j) { return 10 + 3 * i + 2 * j; });
  EXPECT_THAT(HiddenColumns(points), testing::IsEmpty());
}

TEST(TofSurface, LeavesASlantedBoardsOwnPointsAtItsEdges) {
  const auto points = Points([](float i, float) { return i >= 4 && i <= 7 ? 30 + 2 * i : 10.f; });
  for (int column : HiddenColumns(points)) EXPECT_TRUE(column < 4 || column > 7) << column;
}

TEST(TofSurface, HidesLessTheFurtherBesideThePieceWhereTheImagesSayNothing) {
  // The board moves by 4 px against the wall: the next column of the wall is half a cell from its
  // edge, and lies 8 px behind. Odds √(8 / (1 + 0.2 · 4)) = 2.1; (1 + 0.41 · 0.5 / core)² is 2.1
  // for a core of 0.45, 1.9 for 0.55.
  const auto points = Points([](float i, float) { return i >= 4 && i <= 7 ? 18.f : 10.f; });
  EXPECT_THAT(HiddenColumns(points, 0.45), testing::IsEmpty());
  EXPECT_THAT(HiddenColumns(points, 0.55), testing::ElementsAre(3, 8));
}

// The board of column 4 to 7 at 18 px before a wall at 10 px. Between the board's last point, left
// column 60 + 8·7 + 9 = 125, and the wall's next, 129, the edge may be anywhere.
TEST(TofSurface, AsksTheImages) {
  const auto points = Points([](float i, float) { return i >= 4 && i <= 7 ? 18.f : 10.f; });
  const auto hidden_with_edge = [&points](int edge) {
    // Texture that agrees at 18 px left of the edge, and at 10 px from there on.
    cv::Mat1b left(120, 200);
    cv::Mat1b right(120, 200, uint8_t{0});
    cv::theRNG().state = 1;
    cv::randu(left, 0, 255);
    for (int u = 199; u >= 10; --u) {
      if (u >= edge) left.col(u).copyTo(right.col(u - 10));
    }
    for (int u = 18; u < edge; ++u) left.col(u).copyTo(right.col(u - 18));
    const std::vector<int> columns =
        Columns(TofSurface(SomeRig(), points)
                    .FindHidden(points, points.size(), left, right, {0.4, 0.8, 1}));
    return std::count(columns.begin(), columns.end(), 8) == 1;
  };
  EXPECT_TRUE(hidden_with_edge(132));
  EXPECT_FALSE(hidden_with_edge(126));
}

// The board hides the wall's column 8 in the left image, says the geometry; but there the images
// show the wall.
TEST(TofSurface, DoesNotHideAPointThatTheImagesConfirmAtItsOwnPlace) {
  const auto points = Points([](float i, float) { return i >= 4 && i <= 7 ? 26.f : 10.f; });
  cv::Mat1b left(120, 200);
  cv::Mat1b right(120, 200, uint8_t{0});
  cv::theRNG().state = 1;
  cv::randu(left, 0, 255);
  left.colRange(10, 200).copyTo(right.colRange(0, 190));
  TofSurface surface(SomeRig(), points);
  const auto hidden = [&](const cv::Mat1b& other) {
    return Columns(surface.FindHidden(points, points.size(), left, other, {0.75, 0.9, 1}));
  };
  EXPECT_THAT(hidden(right), testing::IsEmpty());
  left.colRange(26, 200).copyTo(right.colRange(0, 174));
  EXPECT_THAT(hidden(right), testing::ElementsAre(3, 8)) << "there they show the board";
}

// A road under a lidar of few beams: 18 px from beam to beam, 6 px of disparity; along a beam,
// where points are 3 px apart and some are missing, nothing of that slant can be seen.
TEST(TofSurface, HidesNothingOnARoadUnderFewBeams) {
  Rig rig = SomeRig();
  rig.pair.width = 420;
  rig.pair.height = 320;
  rig.pair.focal_px = rig.tof.fx = rig.tof.fy = 80;
  rig.tof.width = 420;
  rig.tof.height = 320;
  std::vector<ProjectedPoint> points;
  cv::RNG random(3);
  for (int v = 20; v < 310; v += 18) {
    for (int u = 130; u < 410; u += random.uniform(0, 4) == 0 ? 7 : 3) {
      const int row = v + (u > 260 ? 1 : 0);  // a beam is no straight row
      const float disparity = 5 + static_cast<float>(row) / 3;
      points.push_back(
          {u,
           row,
           {static_cast<float>(u), static_cast<float>(row), static_cast<float>(u) - disparity}});
    }
  }
  std::sort(points.begin(), points.end(), [](const auto& a, const auto& b) {
    return std::pair(a.tof_v, a.tof_u) < std::pair(b.tof_v, b.tof_u);
  });
  TofSurface surface(rig, points);
  const cv::Mat1b grey(rig.pair.size(), uint8_t{100});
  const std::vector<Hidden>& hidden =
      surface.FindHidden(points, points.size(), grey, grey, {0.4, 0.8, 1});
  EXPECT_EQ(std::count(hidden.begin(), hidden.end(), Hidden()), std::ssize(points));
}

TEST(TofSurface, ToleratesSmallSteps) {
  const auto points = Points([](float i, float) { return i >= 4 && i <= 7 ? 18.f : 10.f; });
  EXPECT_THAT(HiddenColumns(points, 0.75, 2), testing::ElementsAre(3, 8));
  EXPECT_THAT(HiddenColumns(points, 0.75, 7.3), testing::IsEmpty());  // and 0.2 · 4 px
}

TEST(TofSurface, DoesNotDependOnTheOrderOfThePoints) {
  auto points = Points([](float i, float j) { return i >= 4 && i <= 7 && j > 2 ? 26.f : 10.f; });
  TofSurface surface(SomeRig(), points);
  const cv::Mat1b grey(120, 200, uint8_t{100});
  const HiddenRule rule{.core = 0.75, .reach = 0.9, .tolerance_px = 1};
  const std::vector<Hidden> forwards = surface.FindHidden(points, points.size(), grey, grey, rule);
  std::reverse(points.begin(), points.end());
  std::vector<Hidden> backwards = surface.FindHidden(points, points.size(), grey, grey, rule);
  std::reverse(backwards.begin(), backwards.end());
  EXPECT_EQ(forwards, backwards);
}

TEST(TofSurface, TakesFlyingPixelsForLoose) {
  // A column between two surfaces, each pixel with another mixture.
  const auto points = Points([](float i, float j) {
    return i < 5 ? 10.f : i > 5 ? 40.f : 14 + std::fmod(7 * j, 10.f) * 2.4f;
  });
  EXPECT_EQ(CountLoose(points), 10);
  EXPECT_EQ(CountLoose(Points([](float i, float) { return i < 5 ? 10.f : 40.f; })), 0);
}

TEST(TofSurface, TheImagesConfirmALoosePointOrDoNot) {
  auto points = Points([](float, float) { return 10.f; });
  ProjectedPoint& thin = points[5 * 12 + 5];
  thin = Point(5, 5, 26);
  const TofSurface surface(SomeRig(), points);
  ASSERT_TRUE(surface.IsIsolated(thin, 2));

  cv::Mat1b left(120, 200);
  cv::randu(left, 0, 255);
  const auto shifted = [&](int disparity) {
    cv::Mat1b right(left.size(), uint8_t{0});
    left.colRange(disparity, left.cols).copyTo(right.colRange(0, left.cols - disparity));
    return right;
  };
  EXPECT_TRUE(surface.IsConfirmed(thin, 2, left, shifted(26)));
  EXPECT_FALSE(surface.IsConfirmed(thin, 2, left, shifted(10))) << "that is the wall's disparity";
  EXPECT_FALSE(surface.IsConfirmed(thin, 2, left, shifted(18))) << "neither's";
  const cv::Mat1b grey(left.size(), uint8_t{100});
  EXPECT_FALSE(surface.IsConfirmed(thin, 2, grey, grey)) << "everything fits";

  const std::vector<ProjectedPoint> alone = {thin};
  EXPECT_FALSE(TofSurface(SomeRig(), alone).IsConfirmed(thin, 2, left, shifted(26)))
      << "nothing to compare it with";
}

TEST(TofSurface, TakesASingleOutlierForLooseAndNotItsNeighbours) {
  auto points = Points([](float, float) { return 10.f; });
  points[5 * 12 + 5] = Point(5, 5, 12.5);
  EXPECT_EQ(CountLoose(points), 1);
  EXPECT_EQ(CountLoose(points, 3), 0);
}

TEST(TofSurface, KeepsSlantsAndThinThings) {
  // Along a line of equal depth each has two neighbours, but for the ends at the image's border.
  const auto slant = Points([](float i, float) { return 10 + 6 * i; });
  EXPECT_THAT(Columns(FindLoose(slant, 2)), testing::IsEmpty());
  EXPECT_EQ(CountLoose(slant), 24);
  const auto pole = Points([](float i, float) { return i == 5 ? 40.f : 10.f; });
  EXPECT_EQ(CountLoose(pole), 2);
}

TEST(TofSurface, CountsPixelsWithoutAPointAsNoSupport) {
  const std::vector<ProjectedPoint> points = {Point(0, 0, 10), Point(1, 0, 10), Point(11, 9, 10)};
  EXPECT_EQ(CountLoose(points), 3);
  EXPECT_EQ(CountLoose({}), 0);
  EXPECT_TRUE(TofSurface(SomeRig(), {}).FindHidden({}, 0, {}, {}, {0.4, 0.8, 1}).empty());
}

// As a lidar's scan is in an image of the left camera's pixels: one in three columns and one in
// four rows has points, and not all of these.
TEST(TofSurface, IsASurfaceWhereFewPixelsHaveAPoint) {
  Rig rig = SomeRig();
  rig.tof.width = 120;
  rig.tof.height = 100;
  std::vector<ProjectedPoint> points;
  for (int j = 0; j < 100; j += 4) {
    for (int i = 0; i < 120; i += 3) {
      if ((i + j) % 7 != 0) points.push_back(Point(i, j, 20));
    }
  }
  points[300].seed.u_right -= 10;
  const TofSurface surface(rig, points);
  EXPECT_EQ(surface.spacing_px(), 4 * 8);
  int loose = 0;
  for (const ProjectedPoint& point : points) loose += surface.IsIsolated(point, 2) ? 1 : 0;
  EXPECT_EQ(loose, 1);
  EXPECT_TRUE(surface.IsIsolated(points[300], 2));
}

// The next point in the same row may be 30 columns away, the next one of all is 4.
TEST(TofSurface, IsASurfaceWherePointsAreScattered) {
  Rig rig = SomeRig();
  rig.tof.width = 120;
  rig.tof.height = 100;
  cv::RNG random(4);
  std::vector<ProjectedPoint> points;
  for (int k = 0; k < 120 * 100; ++k) {
    const int i = k % 120, j = k / 120;
    const double bent = 20 + 0.004 * i * i + 0.003 * j * j;
    if (random.uniform(0., 1.) < 0.05) points.push_back(Point(i, j, static_cast<float>(bent)));
  }
  TofSurface surface(rig, points);
  EXPECT_FALSE(surface.has_pixels());
  EXPECT_NEAR(surface.column_px(), 8 * std::sqrt(1.4 / 0.05), 8);
  EXPECT_NEAR(surface.row_px(), 8 * std::sqrt(1.4 / 0.05), 8);
  EXPECT_LT(surface.Noise(points).middle_px, 1);
}

TEST(TofSurface, EstimatesTheNoiseOfItsPointsAndNotTheirShape) {
  cv::RNG random(5);
  for (const double noise_px : {0.0, 0.7}) {
    Rig rig = SomeRig();
    rig.tof.width = 60;
    rig.tof.height = 50;
    std::vector<ProjectedPoint> points;
    for (int j = 0; j < 50; ++j) {
      for (int i = 0; i < 60; ++i) {
        const double shape = 0.5 * i + (i > 30 ? 12 : 0) - 0.2 * j;
        points.push_back(Point(i, j, static_cast<float>(40 + shape + random.gaussian(noise_px))));
      }
    }
    EXPECT_NEAR(TofSurface(rig, points).Noise(points).middle_px, noise_px, 0.1);
  }
  EXPECT_EQ(TofSurface().Noise({}).middle_px, 0);
}

TEST(TofSurface, EstimatesTheNoiseOfRowsThatHaveAnErrorEach) {
  cv::RNG random(5);
  Rig rig = SomeRig();
  rig.tof.width = 60;
  rig.tof.height = 50;
  std::vector<ProjectedPoint> points;
  for (int j = 0; j < 50; ++j) {
    const double of_row_px = random.gaussian(2);
    for (int i = 0; i < 60; ++i) points.push_back(Point(i, j, static_cast<float>(40 + of_row_px)));
  }
  EXPECT_GT(TofSurface(rig, points).Noise(points).middle_px, 0.4);
}

TEST(TofSurface, EstimatesTheNoiseOfPatchesThatAreFarNoisier) {
  cv::RNG random(5);
  Rig rig = SomeRig();
  rig.tof.width = 64;
  rig.tof.height = 48;
  std::vector<ProjectedPoint> points;
  const auto is_noisy = [](int i, int j) { return i >= 16 && i < 32 && j >= 16 && j < 32; };
  for (int j = 0; j < 48; ++j) {
    for (int i = 0; i < 64; ++i) {
      const double noise_px = is_noisy(i, j) ? 6 : 0.5;
      points.push_back(Point(i, j, static_cast<float>(40 + random.gaussian(noise_px))));
    }
  }
  TofSurface surface(rig, points);
  const RangeNoise noise = surface.Noise(points);
  EXPECT_NEAR(noise.middle_px, 0.5, 0.1);
  for (const ProjectedPoint& point : points) {
    const bool noisy = is_noisy(point.tof_u, point.tof_v);
    EXPECT_NEAR(surface.NoisePxAt(point, noise), noisy ? 6 : noise.middle_px, noisy ? 2 : 0);
  }
}

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Texture, and the same 6 px further left.
struct WindowPair {
  WindowPair() {
    cv::theRNG().state = 7;
    cv::randu(left, 0, 255);
    left.colRange(6, 40).copyTo(right.colRange(0, 34));
  }
  cv::Mat1b left = cv::Mat1b(20, 40);
  cv::Mat1b right = cv::Mat1b(20, 40, uint8_t{0});
};

TEST(WindowDifference, IsZeroAtTheDisparityAndOnePixelBesideIt) {
  const WindowPair pair;
  for (const double off : {-1.4, 0.0, 0.4, 1.4}) {
    EXPECT_EQ(WindowDifference(pair.left, pair.right, 20.3, 9.6, 14 + off), 0) << off;
  }
  EXPECT_GT(WindowDifference(pair.left, pair.right, 20, 10, 16), 0.05);
  EXPECT_GT(WindowDifference(pair.left, pair.right, 20, 10, 12), 0.05);
}

TEST(WindowDifference, IsAShareOfTheSquares) {
  const cv::Mat1b left(9, 9, uint8_t{30});
  const cv::Mat1b right(9, 9, uint8_t{10});
  EXPECT_DOUBLE_EQ(WindowDifference(left, right, 4, 4, 4), 0.4);  // 20² / (30² + 10²)
  const cv::Mat1b black(9, 9, uint8_t{0});
  EXPECT_EQ(WindowDifference(black, black, 4, 4, 4), 0);
}

TEST(WindowDifference, IsInfiniteWhereNoWindowFits) {
  const WindowPair pair;
  EXPECT_EQ(WindowDifference(pair.left, pair.right, 1.4, 10, 10), kInfinity);
  EXPECT_EQ(WindowDifference(pair.left, pair.right, 20, 17.6, 10), kInfinity);
  EXPECT_EQ(WindowDifference(pair.left, pair.right, 20, 10, 0.4), kInfinity);
  EXPECT_LT(WindowDifference(pair.left, pair.right, 20, 10, 0.6), kInfinity);  // one further fits
  EXPECT_EQ(WindowDifference(pair.left, pair.right, 20, 10, -1e30), kInfinity);
}

}  // namespace
}  // namespace sprout::refine
