#include "services/refine/surface/smoothed_edges.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "tests/common/core/centred.h"

namespace sprout::refine {
namespace {

const cv::Size kPixels(80, 60);

// Boards at 32 px before a wall at 12 px.
cv::Mat1f Boards() {
  cv::Mat1f disparities(kPixels, 12);
  for (const cv::Point corner : {cv::Point(10, 10), cv::Point(50, 10), cv::Point(30, 35)}) {
    disparities(cv::Rect(corner, cv::Size(16, 16))) = 32;
  }
  return disparities;
}

cv::Mat1f Smoothed(double sigma) {
  cv::Mat1f disparities;
  cv::GaussianBlur(Boards(), disparities, {}, sigma);
  return disparities;
}

// What is left of an image whose columns and rows lie 5 px apart.
std::vector<ProjectedPoint> Left(const cv::Mat1f& disparities, Smoothing& smoothing) {
  const Rig rig{CentredPair(400, 300, 500), CentredTof(kPixels.width, kPixels.height, 100)};
  std::vector<ProjectedPoint> points;
  for (int v = 0; v < disparities.rows; ++v) {
    for (int u = 0; u < disparities.cols; ++u) {
      const auto column = static_cast<float>(5 * u);
      points.push_back({u, v, {column, static_cast<float>(5 * v), column - disparities(v, u)}});
    }
  }
  const auto all = static_cast<double>(points.size());
  smoothing = DropSmoothed(TofSurface(rig, points), points);
  EXPECT_NEAR(smoothing.dropped_share, 1 - static_cast<double>(points.size()) / all, 1e-9);
  return points;
}

TEST(SmoothedEdges, AreAsWideAsTheFilter) {
  for (const double sigma : {1.0, 1.5, 2.0}) {
    Smoothing smoothing;
    const auto left = Left(Smoothed(sigma), smoothing);
    EXPECT_NEAR(smoothing.edge_width, 2.5 * sigma, 0.6 * sigma);
    EXPECT_GT(left.size(), 1500U);
    for (const ProjectedPoint& point : left) {
      const float truth = Boards()(point.tof_v, point.tof_u);
      ASSERT_NEAR(point.seed.disparity(), truth, 1) << point.tof_u << " " << point.tof_v;
    }
  }
}

TEST(SmoothedEdges, AreThoseAlongRowsAlone) {
  cv::Mat1f disparities;
  cv::GaussianBlur(Boards(), disparities, {}, 1.5, 0.01);
  Smoothing smoothing;
  Left(disparities, smoothing);
  EXPECT_NEAR(smoothing.edge_width, 3.75, 0.9);
}

TEST(SmoothedEdges, AreNoneOfASharpImage) {
  Smoothing smoothing;
  cv::Mat1f mixed;  // each pixel sees as much of both surfaces as lies in it
  cv::blur(Boards(), mixed, {2, 1});
  for (const cv::Mat1f& disparities : {Boards(), mixed}) {
    EXPECT_EQ(Left(disparities, smoothing).size(), static_cast<size_t>(kPixels.area()));
    EXPECT_FALSE(smoothing);
  }
}

TEST(SmoothedEdges, AreNoSlants) {
  cv::Mat1f slant(kPixels);
  for (int v = 0; v < slant.rows; ++v) slant.row(v) = static_cast<float>(3 * v);
  Smoothing smoothing;
  EXPECT_EQ(Left(slant, smoothing).size(), static_cast<size_t>(kPixels.area()));
  EXPECT_FALSE(smoothing);
}

}  // namespace
}  // namespace sprout::refine
