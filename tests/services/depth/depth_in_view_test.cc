#include "services/depth/depth_in_view.h"

#include <gtest/gtest.h>

#include <numbers>

#include "tests/common/core/centred.h"

namespace sprout::depth {
namespace {

// f·b = 10 px·m: 10 px are 1 m.
constexpr RectifiedPair kMappedPair = CentredPair(40, 30, 100);

DisparityImage Plane(int px) {
  return DisparityImage(cv::Mat1s(30, 40, static_cast<int16_t>(32 * px)));
}

View Same() {
  return {.size = {40, 30}, .focal_px = 100, .cx = 20, .cy = 15, .view_from_left = {}};
}

View At(const Eigen::Vector3d& place_m) {
  View view = Same();
  view.view_from_left.translation_m = -place_m;
  return view;
}

cv::Mat1w DepthIn(const View& view, const DisparityImage& map) {
  return DepthInView(map, kMappedPair, view, 0.001).counts;
}

// Both are the same size.
int Differing(const cv::Mat1w& a, const cv::Mat1w& b) { return cv::countNonZero(a != b); }

TEST(DepthInView, OfTheLeftCameraIsItsOwn) {
  DisparityImage map = Plane(4);
  map.counts()(cv::Rect(10, 8, 7, 5)) = 320;
  map.counts()(4, 3) = DisparityImage::kInvalid;
  cv::Mat1w expected(30, 40, uint16_t{2500});
  expected(cv::Rect(10, 8, 7, 5)) = 1000;
  expected(4, 3) = 0;
  EXPECT_EQ(Differing(DepthIn(Same(), map), expected), 0);
}

TEST(DepthInView, SaysTheViewsIntrinsics) {
  const View view{.size = {8, 6}, .focal_px = 20, .cx = 3, .cy = 2, .view_from_left = {}};
  const DepthImage depth = DepthInView(Plane(10), kMappedPair, view, 0.002);
  EXPECT_EQ(depth.size(), cv::Size(8, 6));
  EXPECT_EQ(depth.focal_px, 20);
  EXPECT_EQ(depth.cx, 3);
  EXPECT_EQ(depth.cy, 2);
  EXPECT_EQ(depth.Metres(3, 2), 1);
  EXPECT_EQ(depth.counts(3, 2), 500);
}

// 5 cm to the right, at 1 m: 5 px to the left. What the left camera does not see stays empty.
TEST(DepthInView, MovesWithParallaxAndLeavesWhatIsNotSeenEmpty) {
  cv::Mat1w expected(30, 40, uint16_t{1000});
  expected(cv::Rect(35, 0, 5, 30)) = 0;
  EXPECT_EQ(Differing(DepthIn(At({0.05, 0, 0}), Plane(10)), expected), 0);
}

TEST(DepthInView, MeasuresAlongTheViewsAxis) {
  const cv::Mat1w depth = DepthIn(At({0, 0, 0.2}), Plane(10));
  EXPECT_EQ(depth(15, 20), 800);
  EXPECT_EQ(cv::countNonZero(depth != 800), 0) << "a plane that is magnified has no holes";
}

// A box at 1 m in front of a wall at 2.5 m; 5 cm to the right it moves by 5 px and the wall by 2.
TEST(DepthInView, KeepsTheNearestAndMakesNothingUpBehindIt) {
  DisparityImage map = Plane(4);
  map.counts()(cv::Rect(15, 10, 10, 10)) = 320;
  cv::Mat1w expected(30, 40, uint16_t{2500});
  expected(cv::Rect(38, 0, 2, 30)) = 0;
  expected(cv::Rect(13, 10, 10, 10)) = 0;  // where the wall of the box's place would be
  expected(cv::Rect(10, 10, 10, 10)) = 1000;
  EXPECT_EQ(Differing(DepthIn(At({0.05, 0, 0}), map), expected), 0);
}

// Four times as many pixels a side: whole surfaces, and nothing between the box and the wall.
TEST(DepthInView, ClosesHolesOnOneSurfaceOnly) {
  DisparityImage map = Plane(4);
  map.counts()(cv::Rect(15, 10, 10, 10)) = 320;
  View view = At({0.05, 0, 0});
  view.size = {160, 120};
  view.focal_px = 400;
  view.cx = 81.5;  // the corners of both images coincide
  view.cy = 61.5;
  const cv::Mat1w depth = DepthIn(view, map);
  cv::Mat1w expected(120, 160, uint16_t{2500});
  expected(cv::Rect(152, 0, 8, 120)) = 0;
  expected(cv::Rect(52, 40, 40, 40)) = 0;
  expected(cv::Rect(40, 40, 40, 40)) = 1000;
  EXPECT_EQ(Differing(depth, expected), 0);
}

TEST(DepthInView, TurnsWithTheView) {
  DisparityImage map = Plane(4);
  map.counts()(10, 30) = 320;
  View view{.size = {30, 40}, .focal_px = 100, .cx = 15, .cy = 20, .view_from_left = {}};
  // The view's x axis is the left camera's −y.
  view.view_from_left.rotation =
      Eigen::Quaterniond(Eigen::AngleAxisd(std::numbers::pi / 2, Eigen::Vector3d::UnitZ()));
  const cv::Mat1w depth = DepthIn(view, map);
  // (30, 10) is (0.1, −0.05, 1), there (0.05, 0.1, 1).
  EXPECT_EQ(depth(30, 20), 1000);
  EXPECT_EQ(cv::countNonZero(depth == 1000), 1);
  EXPECT_EQ(cv::countNonZero(depth == 2500), 30 * 40 - 1 - 40) << "one column is not seen";
}

TEST(DepthInView, LooksNotBehindItself) {
  EXPECT_EQ(cv::countNonZero(DepthIn(At({0, 0, 3}), Plane(4))), 0);
  EXPECT_EQ(cv::countNonZero(DepthIn(Same(), DisparityImage(kMappedPair.size()))), 0);
}

// 3 m ahead, and turned round: it sees the backs of a wall and of a box, which the map does not.
TEST(DepthInView, ShowsNothingFromBehind) {
  DisparityImage map = Plane(4);
  map.counts()(cv::Rect(15, 10, 10, 10)) = 320;
  View view = Same();
  view.view_from_left = {.rotation = {0, 0, 1, 0}, .translation_m = {0, 0, 3}};
  EXPECT_EQ(cv::countNonZero(DepthIn(view, map)), 0);
}

TEST(DepthInView, LeavesOutWhatHasNoNumber) {
  EXPECT_EQ(cv::countNonZero(DepthInView(Plane(1), kMappedPair, Same(), 0.0001).counts), 0)
      << "10 m are 100000 counts";
}

TEST(DepthInView, IsTheSameWithAnyNumberOfThreads) {
  DisparityImage map = Plane(4);
  for (int v = 0; v < 30; ++v) {
    for (int u = 0; u < 40; ++u) {
      map.counts()(v, u) = static_cast<int16_t>((u * 37 + v * 101) % 64 + 32 * (4 + u / 9));
    }
  }
  const int threads = cv::getNumThreads();
  cv::setNumThreads(1);
  const cv::Mat1w one = DepthIn(At({0.03, 0.01, 0.9}), map);
  cv::setNumThreads(3);
  const cv::Mat1w three = DepthIn(At({0.03, 0.01, 0.9}), map);
  cv::setNumThreads(threads);
  EXPECT_EQ(Differing(one, three), 0);
  EXPECT_GT(cv::countNonZero(one), 100);
}

TEST(CloudInView, HasTheViewsPointsWithTheLeftColours) {
  cv::Mat3b left(30, 40);
  cv::Mat1b confidence(30, 40);
  for (int v = 0; v < 30; ++v) {
    for (int u = 0; u < 40; ++u) {
      left(v, u) = {static_cast<uint8_t>(u), static_cast<uint8_t>(v), 7};
      confidence(v, u) = static_cast<uint8_t>(u + v);
    }
  }
  const View view = At({0.05, 0, 0});
  const DepthImage depth = DepthInView(Plane(10), kMappedPair, view, 0.001);
  const PointCloud cloud = CloudInView(depth, view, kMappedPair, left, confidence, {.stride = 10});
  ASSERT_EQ(cloud.points.size(), 4U * 3);
  // Pixel (10, 20) of the view is (15, 20) of the left image.
  const CloudPoint& point = cloud.points[2 * 4 + 1];
  EXPECT_EQ(point.position_m, cv::Point3f(-0.1F, 0.05F, 1));
  EXPECT_EQ(point.bgr, cv::Vec3b(15, 20, 7));
  EXPECT_EQ(point.confidence, 35);
}

TEST(ViewOf, IsTheCameraWithoutItsDistortion) {
  const Lens lens{
      .width = 64, .height = 48, .fx = 50, .fy = 51, .cx = 30, .cy = 20, .distortion = {0.1}};
  const View view = ViewOf(lens, {.rotation = {0, 0, 0, 1}, .translation_m = {1, 2, 3}});
  EXPECT_EQ(view.size, cv::Size(64, 48));
  EXPECT_EQ(view.focal_px, 50);
  EXPECT_EQ(view.cx, 30);
  EXPECT_EQ(view.cy, 20);
  // Half a turn about z.
  EXPECT_EQ(view.view_from_left.translation_m, Eigen::Vector3d(1, 2, -3));
}

}  // namespace
}  // namespace sprout::depth
