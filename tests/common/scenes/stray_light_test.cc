#include "common/scenes/stray_light.h"

#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>

namespace sprout::scenes {
namespace {

constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();
constexpr int kRoomWidth = 80;
constexpr int kRoomHeight = 60;
constexpr double kRoomFocalPx = 60;  // 67° wide

std::vector<Eigen::Vector3d> Directions() {
  std::vector<Eigen::Vector3d> directions;
  for (int v = 0; v < kRoomHeight; ++v) {
    for (int u = 0; u < kRoomWidth; ++u) {
      directions.emplace_back((u - 39.5) / kRoomFocalPx, (v - 29.5) / kRoomFocalPx, 1);
    }
  }
  return directions;
}

// What a camera sees of planes n·X = 1, the nearest of those in front; albedo 0.5.
struct Room {
  explicit Room(const std::vector<Eigen::Vector3d>& planes) {
    for (int i = 0; i < kRoomWidth * kRoomHeight; ++i) {
      double z = 1e9;
      for (const Eigen::Vector3d& plane : planes) {
        const double plane_m = 1 / plane.dot(directions[static_cast<size_t>(i)]);
        if (plane_m > 0) z = std::min(z, plane_m);
      }
      depth_m(i) = z;
      light(i) = 0.5 / (z * z);
    }
  }

  cv::Mat1d Error(const StrayLight& stray) const {
    return StrayLightErrorM({depth_m, light, kRoomFocalPx, directions}, stray);
  }

  std::vector<Eigen::Vector3d> directions = Directions();
  cv::Mat1d depth_m = cv::Mat1d(kRoomHeight, kRoomWidth);
  cv::Mat1d light = cv::Mat1d(kRoomHeight, kRoomWidth);
};

// A corner 3 m away, its walls at 45° to the axis: x + z = 3, −x + z = 3.
Room Corner() { return Room({{1 / 3.0, 0, 1 / 3.0}, {-1 / 3.0, 0, 1 / 3.0}}); }
Room Wall() { return Room({{0, 0, 0.5}}); }

TEST(Phasor, HasThePhaseThatItWasMadeWith) {
  for (double turns = -0.499; turns < 0.5; turns += 0.0037) {
    const Phasor phasor = 3.0 * UnitPhasor(turns);
    EXPECT_NEAR(TurnsOf(phasor), turns, 1e-11);
    EXPECT_NEAR(TurnsOf(phasor), std::arg(phasor) / (2 * M_PI), 1e-11);
  }
  EXPECT_EQ(TurnsOf({0, 0}), 0);
  EXPECT_EQ(TurnsOf({-1, 0}), 0.5);
}

TEST(StrayLight, DoesNothingToAFlatWallByMultipath) {
  const cv::Mat1d error_m = Wall().Error({.multipath = 0.5});
  EXPECT_LT(cv::norm(error_m, cv::NORM_INF), 1e-6);
}

TEST(StrayLight, MakesACornerTooFarSmoothlyAndInProportionToItsAlbedo) {
  const cv::Mat1d error_m = Corner().Error({.multipath = 0.3});
  double least = 0;
  double most = 0;
  cv::minMaxLoc(error_m, &least, &most);
  EXPECT_GT(least, 0);  // every way by another wall is longer
  EXPECT_GT(most, 0.02);
  EXPECT_LT(most, 0.3);
  cv::Mat1d mirrored;
  cv::flip(error_m, mirrored, 1);
  EXPECT_LT(cv::norm(error_m, mirrored, cv::NORM_INF), 1e-9);
  cv::Mat1d steps;
  cv::absdiff(error_m.colRange(1, 36), error_m.colRange(0, 35), steps);
  double largest = 0;
  cv::minMaxLoc(steps, nullptr, &largest);
  EXPECT_LT(largest, 0.2 * most);
  const cv::Mat1d darker = Corner().Error({.multipath = 0.03});
  EXPECT_NEAR(cv::sum(darker)[0] / cv::sum(error_m)[0], 0.1, 0.03);
}

// One pixel by hand: the left wall's at the middle of the picture's left half, lit by one patch.
TEST(StrayLight, TakesLightByWayOfAPatchAsTheFormFactorSays) {
  Room room = Corner();
  // Only one patch of the right wall and one pixel of the left one are there.
  cv::Mat1d kept(kRoomHeight, kRoomWidth, kNothing);
  const cv::Rect patch(56, 24, 8, 8);
  room.depth_m(patch).copyTo(kept(patch));
  const cv::Point pixel(19, 28);
  kept(pixel) = room.depth_m(pixel);
  // The pixel's normal needs neighbours, of no light.
  for (int v = -4; v <= 4; ++v) {
    for (int u = -4; u <= 4; ++u) {
      const cv::Point at = pixel + cv::Point(u, v);
      kept(at) = room.depth_m(at);
      if (at != pixel) room.light(at) = 0;
    }
  }
  room.depth_m = kept;
  double albedo = 0;
  int count = 0;
  for (int i = 0; i < kRoomWidth * kRoomHeight; ++i) {
    if (std::isnan(kept(i))) continue;
    albedo += room.light(i) * kept(i) * kept(i);
    ++count;
  }
  albedo /= count;
  const auto at = [&](double u, double v, double wall) {  // wall: 1 right, −1 left
    const Eigen::Vector3d direction((u - 39.5) / kRoomFocalPx, (v - 29.5) / kRoomFocalPx, 1);
    return Eigen::Vector3d(direction * 3 / (1 + wall * direction.x()));
  };
  // The patch in 64 small pieces.
  const Eigen::Vector3d p = at(pixel.x, pixel.y, -1);
  const Eigen::Vector3d left = Eigen::Vector3d(1, 0, -1).normalized();
  const Eigen::Vector3d right = Eigen::Vector3d(-1, 0, -1).normalized();
  double real = room.light(pixel);
  double imaginary = 0;
  for (int v = patch.y; v < patch.br().y; ++v) {
    for (int u = patch.x; u < patch.br().x; ++u) {
      const Eigen::Vector3d q = at(u, v, 1);
      const Eigen::Vector3d way = q - p;
      const double area = (at(u + 0.5, v, 1) - at(u - 0.5, v, 1))
                              .cross(at(u, v + 0.5, 1) - at(u, v - 0.5, 1))
                              .norm();
      const double form = left.dot(way) * -right.dot(way) / (M_PI * std::pow(way.norm(), 4)) * area;
      const double signal =
          room.light(pixel) * p.z() * p.z() * 0.5 / albedo * form * room.light(v, u);
      const double later = 2 * M_PI * (q.norm() + way.norm() - p.norm()) / 2 / 5;
      real += signal * std::cos(later);
      imaginary += signal * std::sin(later);
    }
  }
  const double expected_m = std::atan2(imaginary, real) / (2 * M_PI) * 5;
  ASSERT_GT(expected_m, 1e-4);
  EXPECT_NEAR(room.Error({.multipath = 0.5})(pixel), expected_m, 0.05 * expected_m);
}

TEST(StrayLight, DrawsWhatIsFarAndDarkTowardsWhatIsNearAndBright) {
  Room room = Wall();
  const cv::Rect near(0, 0, 20, kRoomHeight);
  room.depth_m(near) = 1.0;
  room.light(near) = 0.5;
  const cv::Mat1d error_m = room.Error({.scatter = 0.02});
  EXPECT_GT(error_m(30, 5), 0);
  EXPECT_LT(error_m(30, 70), -0.005);
  EXPECT_GT(error_m(30, 70), -0.1);
  EXPECT_LT(std::abs(error_m(30, 5)), std::abs(error_m(30, 70)));
  // By the formula at one pixel.
  double real = 0;
  double imaginary = 0;
  const auto phase = [&](int i) {
    return 2 * M_PI * room.depth_m(i) * room.directions[static_cast<size_t>(i)].norm() / 5;
  };
  for (int i = 0; i < kRoomWidth * kRoomHeight; ++i) {
    real += room.light(i) * std::cos(phase(i)) / (kRoomWidth * kRoomHeight);
    imaginary += room.light(i) * std::sin(phase(i)) / (kRoomWidth * kRoomHeight);
  }
  const int i = 30 * kRoomWidth + 70;
  const double after = std::atan2(0.98 * room.light(i) * std::sin(phase(i)) + 0.02 * imaginary,
                                  0.98 * room.light(i) * std::cos(phase(i)) + 0.02 * real);
  EXPECT_NEAR(error_m(i), (after - phase(i)) / (2 * M_PI) * 5, 1e-9);
}

TEST(StrayLight, LeavesWhatIsUnknownAlone) {
  Room room = Corner();
  room.depth_m(cv::Rect(0, 0, 80, 10)) = kNothing;
  const cv::Mat1d error_m = room.Error({.multipath = 0.3, .scatter = 0.02});
  EXPECT_EQ(cv::countNonZero(error_m.rowRange(0, 10)), 0);
  EXPECT_TRUE(cv::checkRange(error_m));
  room.depth_m = kNothing;
  EXPECT_EQ(cv::countNonZero(room.Error({.multipath = 0.3, .scatter = 0.02})), 0);
}

}  // namespace
}  // namespace sprout::scenes
