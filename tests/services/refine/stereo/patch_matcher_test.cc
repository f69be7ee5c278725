#include "services/refine/stereo/patch_matcher.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <utility>

#include "tests/common/testing/instruction_sets.h"

namespace sprout::refine {
namespace {

const cv::Size kPatchImage(80, 60);

// Waves of 9 to 30 px, so that any place has texture.
double Waves(double u, double v) {
  return 128 + 40 * std::sin(0.7 * u + 0.2 * v) + 30 * std::sin(0.21 * u - 0.33 * v) +
         20 * std::sin(0.45 * u + 0.5 * v);
}

// A plane of the left image, seen by both cameras. @param brighter  the left image.
std::pair<cv::Mat1b, cv::Mat1b> SeePlane(const SlantedPatch& plane, double brighter = 0) {
  std::pair<cv::Mat1b, cv::Mat1b> pair{cv::Mat1b(kPatchImage), cv::Mat1b(kPatchImage)};
  for (int v = 0; v < kPatchImage.height; ++v) {
    for (int u = 0; u < kPatchImage.width; ++u) {
      const double disparity =
          plane.disparity_px + plane.slope.x * (u - plane.at.x) + plane.slope.y * (v - plane.at.y);
      pair.first(v, u) = cv::saturate_cast<uint8_t>(Waves(u - disparity, v) + brighter);
      pair.second(v, u) = cv::saturate_cast<uint8_t>(Waves(u, v));
    }
  }
  return pair;
}

TEST(MatchPatch, FindsTheDisparityOfSlantedPlanesBetweenPixels) {
  for (const cv::Point2d slope :
       {cv::Point2d(0, 0), cv::Point2d(0.2, -0.1), cv::Point2d(-0.3, 0.35)}) {
    for (double disparity = 12; disparity < 13; disparity += 0.19) {
      const SlantedPatch plane{{40.5, 30.5}, disparity, slope};
      const auto [left, right] = SeePlane(plane, 15);
      for (const double off : {-0.7, 0.3, 0.8}) {
        SlantedPatch start = plane;
        start.disparity_px += off;
        const std::optional<double> found = MatchPatch(left, right, start, 1);
        ASSERT_TRUE(found);
        EXPECT_NEAR(*found, disparity, 0.1) << slope << " " << disparity << " " << off;
      }
    }
  }
}

TEST(MatchPatch, ChangesTheDisparityByNoMoreThanAllowed) {
  SlantedPatch patch{{40, 30}, 12, {}};
  const auto [left, right] = SeePlane(patch);
  patch.disparity_px = 13.5;
  EXPECT_DOUBLE_EQ(MatchPatch(left, right, patch, 0.5).value(), 13);
  patch.disparity_px = 10.5;
  EXPECT_DOUBLE_EQ(MatchPatch(left, right, patch, 0.25).value(), 10.75);
}

TEST(MatchPatch, TakesTheSameOnePixelBeside) {
  // The window is around the nearest pixel: the patch's slope leads back to its own place.
  const SlantedPatch plane{{40, 30}, 12, {0.3, 0.2}};
  const auto [left, right] = SeePlane(plane);
  const SlantedPatch beside{{40.4, 29.6}, 12 + 0.3 * 0.4 - 0.2 * 0.4, plane.slope};
  EXPECT_NEAR(MatchPatch(left, right, beside, 1).value(),
              MatchPatch(left, right, plane, 1).value() + 0.04, 1e-9);
}

TEST(MatchPatch, RefusesWhatItCannotMatch) {
  const SlantedPatch patch{{40, 30}, 12, {}};
  const auto [left, right] = SeePlane(patch);
  EXPECT_TRUE(MatchPatch(left, right, patch, 1));
  const cv::Mat1b plain(kPatchImage, uint8_t{90});
  EXPECT_FALSE(MatchPatch(plain, plain, patch, 1));
  EXPECT_FALSE(MatchPatch(left, right, {patch.at, 12, {0.41, 0}}, 1));
  EXPECT_FALSE(MatchPatch(left, right, {patch.at, 12, {0, -0.41}}, 1));
  EXPECT_FALSE(MatchPatch(left, right, {patch.at, 35, {}}, 1));   // leaves the right image
  EXPECT_FALSE(MatchPatch(left, right, {patch.at, -36, {}}, 1));  // on the other side
  for (const cv::Point2d at : {cv::Point2d(40, 3), cv::Point2d(40, 57), cv::Point2d(4, 30),
                               cv::Point2d(76, 30), cv::Point2d(-100, 30), cv::Point2d(40, 1e4)}) {
    EXPECT_FALSE(MatchPatch(left, right, {at, 0, {}}, 1)) << at;
  }
  const cv::Mat1b tiny(3, 5, uint8_t{90});
  EXPECT_FALSE(MatchPatch(tiny, tiny, {{2, 1}, 0, {}}, 1));
}

// Everything an image can hold: sums of the largest contrast fit into their numbers, and are the
// same with any instruction set. Expected from a plain sum in wide numbers.
TEST(MatchPatch, IsTheSameWithAnyInstructionSet) {
  cv::Mat1b left(kPatchImage), right(kPatchImage);
  cv::RNG random(5);
  for (int i = 0; i < 50; ++i) {
    random.fill(left, cv::RNG::UNIFORM, 0, 256);
    random.fill(right, cv::RNG::UNIFORM, 0, 256);
    if (i % 2 == 0) {  // black and white
      left = (left > 127);
      right = (right > 127);
    }
    const SlantedPatch patch{{random.uniform(25.0, 70.0), random.uniform(5.0, 55.0)},
                             random.uniform(0.0, 15.0),
                             {random.uniform(-0.4, 0.4), random.uniform(-0.4, 0.4)}};
    const cv::Point at(static_cast<int>(std::lround(patch.at.x)),
                       static_cast<int>(std::lround(patch.at.y)));
    double start = patch.disparity_px + patch.slope.x * (at.x - patch.at.x) +
                   patch.slope.y * (at.y - patch.at.y);
    const double first = start;
    for (int round = 0; round < 2; ++round) {
      double g_sum = 0, rho_sum = 0, g_rho = 0, g_g = 0;
      for (int y = -4; y < 4; ++y) {
        for (int x = -4; x < 4; ++x) {
          const double along_row = start + patch.slope.y * y;
          const double place = at.x + x - along_row;
          const int whole = static_cast<int>(std::floor(place));
          const double part = place - whole;
          const auto grey = [&](int u) { return static_cast<double>(right(at.y + y, u)); };
          const auto left_grey = [&](int u) { return static_cast<double>(left(at.y + y, u)); };
          const double value = (1 - part) * grey(whole) + part * grey(whole + 1);
          const double rise = (1 - part) * (grey(whole + 1) - grey(whole - 1)) +
                              part * (grey(whole + 2) - grey(whole));
          const double g = (rise + left_grey(at.x + x + 1) - left_grey(at.x + x - 1)) / 4;
          const double rho = left_grey(at.x + x) - value + g * patch.slope.x * x;
          g_sum += g;
          rho_sum += rho;
          g_rho += g * rho;
          g_g += g * g;
        }
      }
      const double step = -(g_rho - g_sum * rho_sum / 64) / (g_g - g_sum * g_sum / 64);
      start = std::clamp(start + step, first - 1, first + 1);
      if (std::abs(step) < 0.25) break;
    }
    const double expected = start - first + patch.disparity_px;
    std::optional<double> of_first_set;
    ForEachInstructionSet([&](const std::string& set) {
      const std::optional<double> found = MatchPatch(left, right, patch, 1);
      ASSERT_TRUE(found);
      EXPECT_NEAR(*found, expected, 0.1) << set << ", image " << i;
      if (!of_first_set) of_first_set = found;
      EXPECT_EQ(found, of_first_set) << set;
    });
  }
}

}  // namespace
}  // namespace sprout::refine
