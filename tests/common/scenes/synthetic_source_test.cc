#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "common/core/image.h"
#include "common/geometry/projection.h"
#include "common/scenes/dataset.h"

namespace sprout::scenes {
namespace {

std::unique_ptr<Dataset> Open(const std::string& size, uint32_t seed = 1) {
  CaptureConfig config;
  config.set_source("synthetic:" + size);
  config.set_seed(seed);
  return OpenDataset(config);
}

bool SameBytes(const cv::Mat& a, const cv::Mat& b) {
  return a.type() == b.type() && a.size() == b.size() && a.isContinuous() && b.isContinuous() &&
         std::memcmp(a.data, b.data, a.total() * a.elemSize()) == 0;
}

bool SameBytes(const DatasetFrame& a, const DatasetFrame& b) {
  return SameBytes(a.left, b.left) && SameBytes(a.right, b.right) &&
         SameBytes(a.truth.left, b.truth.left) && SameBytes(a.truth.right, b.truth.right) &&
         SameBytes(a.tof.depth_m, b.tof.depth_m);
}

// Row `v` of an image at a column between two pixels.
template <typename T>
double Between(const cv::Mat_<T>& image, int v, double u) {
  const int left = std::min(static_cast<int>(u), image.cols - 2);
  const double weight = u - left;
  return (1 - weight) * image(v, left) + weight * image(v, left + 1);
}

TEST(SyntheticDataset, GivesTheSameBytesForTheSameIndexAndSeed) {
  const auto source = Open("161x120");
  const DatasetFrame first = source->Get(7);
  source->Get(3);
  EXPECT_TRUE(SameBytes(first, source->Get(7)));
  EXPECT_TRUE(SameBytes(first, Open("161x120")->Get(7)));
}

// A frame as one thread makes it, and two.
std::pair<DatasetFrame, DatasetFrame> AloneAndTogether(Dataset& source) {
  const int threads = cv::getNumThreads();
  cv::setNumThreads(1);
  DatasetFrame alone = source.Get(11);
  cv::setNumThreads(2);
  DatasetFrame together = source.Get(11);
  cv::setNumThreads(threads);
  return {std::move(alone), std::move(together)};
}

TEST(SyntheticDataset, DoesNotDependOnTheNumberOfThreads) {
  const auto [alone, together] = AloneAndTogether(*Open("320x240"));
  EXPECT_TRUE(SameBytes(alone, together));
}

TEST(SyntheticDataset, ShowsTheSceneToAnSr4000InItsOwnPlace) {
  CaptureConfig config;
  config.set_source("synthetic:320x240?tof=sr4000");
  config.mutable_sr4000()->set_depth_noise_m(0);
  config.mutable_sr4000()->set_flying_pixels(0);
  config.mutable_sr4000()->set_min_amplitude(0);
  const auto source = OpenDataset(config);
  const DatasetFrame frame = source->Get(4);
  ASSERT_EQ(frame.tof.depth_m.size(), cv::Size(176, 144));
  ASSERT_EQ(frame.tof.amplitude.size(), cv::Size(176, 144));
  int behind = 0;
  int seen_by_left = 0;
  int hidden_from_left = 0;
  int nowhere = 0;
  for (const auto& point : TofProjector(source->rig()).Project(frame.tof, behind)) {
    const cv::Point pixel(static_cast<int>(std::lround(point.seed.u)),
                          static_cast<int>(std::lround(point.seed.v)));
    if (!cv::Rect(0, 0, 320, 240).contains(pixel)) continue;
    const double nearer_px = frame.truth.left(pixel) - point.seed.disparity();
    ++(nearer_px > 0.5 ? hidden_from_left : nearer_px > -0.5 ? seen_by_left : nowhere);
  }
  EXPECT_GT(seen_by_left, 10000);
  EXPECT_GT(hidden_from_left, 200);
  EXPECT_LT(nowhere, 0.02 * seen_by_left);  // positions rounded across an edge
}

TEST(SyntheticDataset, GivesTheSameSr4000BytesWithAnyNumberOfThreads) {
  const auto [alone, together] = AloneAndTogether(*Open("160x120?tof=sr4000"));
  EXPECT_TRUE(SameBytes(alone, together));
  EXPECT_TRUE(SameBytes(alone.tof.amplitude, together.tof.amplitude));
  EXPECT_FALSE(SameBytes(alone.tof.depth_m, Open("160x120?tof=sr4000", 2)->Get(11).tof.depth_m));
}

TEST(SyntheticDataset, LooksDifferentWithAnotherSeed) {
  const DatasetFrame one = Open("160x120", 1)->Get(0);
  for (uint32_t seed : {0u, 2u, 4294967295u}) {
    const DatasetFrame other = Open("160x120", seed)->Get(0);
    EXPECT_FALSE(SameBytes(one.left, other.left)) << seed;
    EXPECT_FALSE(SameBytes(one.truth.left, other.truth.left)) << seed;
  }
}

TEST(SyntheticDataset, MovesFromFrameToFrame) {
  const auto source = Open("160x120");
  for (int64_t index : {int64_t{0}, int64_t{100}, int64_t{1} << 60}) {
    EXPECT_FALSE(SameBytes(source->Get(index).truth.left, source->Get(index + 1).truth.left));
  }
  EXPECT_EQ(source->frame_count(), std::nullopt);
}

TEST(SyntheticDataset, KeepsItsDisparitiesWithinTheirRange) {
  for (uint32_t seed = 0; seed < 20; ++seed) {
    const auto source = Open("160x120", seed);
    for (int64_t index : {0, 37, 90}) {
      double min_px = 0;
      double max_px = 0;
      cv::minMaxLoc(source->Get(index).truth.left, &min_px, &max_px);
      EXPECT_GT(min_px, 0.015 * 160) << seed;
      EXPECT_LT(min_px, 0.025 * 160) << seed;
      EXPECT_GT(max_px, 0.08 * 160) << seed;
      EXPECT_LT(max_px, 0.17 * 160) << seed;
    }
  }
}

// At the bottom of the images lies the floor, 1.6 m away, and nothing hides the corners of both. It
// is seen at u − u' = f·b/Z − (cx' − cx): 576·0.2/1.6 − 6.4, half a pixel's row nearer to the
// middle.
TEST(SyntheticDataset, HasTwoPrincipalPoints) {
  const auto source = Open("640x480");
  const RectifiedPair pair = source->rig().pair;
  EXPECT_DOUBLE_EQ(pair.focal_px, 576);
  EXPECT_DOUBLE_EQ(pair.baseline_m, 0.2);
  EXPECT_DOUBLE_EQ(pair.cx, 319.5);
  EXPECT_DOUBLE_EQ(pair.cy, 239.5);
  EXPECT_DOUBLE_EQ(pair.cx_right, 319.5 + 6.4);
  const double depth_m = 1.6 * 240 / 239.5;
  const GroundTruth truth = source->Get(0).truth;
  EXPECT_NEAR(truth.left(479, 639), 576 * 0.2 / depth_m - 6.4, 1e-3);
  EXPECT_NEAR(truth.right(479, 0), 576 * 0.2 / depth_m - 6.4, 1e-3);
  EXPECT_DOUBLE_EQ(Open("12000x64")->rig().pair.cx_right, 5999.5 + 60) << "with half the baseline";
}

TEST(SyntheticDataset, FitsIntoADisparityImageAtItsWidest) {
  double max_px = 0;
  cv::minMaxLoc(Open("16384x64")->Get(0).truth.left, nullptr, &max_px);
  EXPECT_LT(max_px, 1023);
}

// Where the right view has to show the same surface or something nearer, and mostly the same.
TEST(SyntheticDataset, AgreesBetweenLeftAndRightTruth) {
  for (uint32_t seed : {1u, 2u, 3u}) {
    const GroundTruth truth = Open("640x480", seed)->Get(25).truth;
    int inside = 0;
    int same = 0;
    int seen_through = 0;
    for (int v = 0; v < truth.left.rows; ++v) {
      for (int u = 0; u < truth.left.cols; ++u) {
        const double d = truth.left(v, u);
        if (u - d < 0) continue;
        ++inside;
        const double on_right = Between(truth.right, v, u - d);
        if (std::abs(on_right - d) < 0.01) ++same;
        if (on_right < d - 0.5) ++seen_through;
      }
    }
    EXPECT_GT(inside, 0.8 * static_cast<double>(truth.left.total())) << seed;
    EXPECT_GT(same, 0.85 * inside) << seed;
    EXPECT_LT(seen_through, 0.005 * inside) << seed;  // interpolation across an edge
  }
}

// Mean difference of grey values between left and right, with `shift` px added to the true
// disparity, over pixels that both views see and that have texture.
double MeanDifference(const DatasetFrame& frame, double shift) {
  const cv::Mat1b left = ToGrey(frame.left);
  const cv::Mat1b right = ToGrey(frame.right);
  double sum = 0;
  int count = 0;
  for (int v = 0; v < left.rows; ++v) {
    for (int u = 1; u + 1 < left.cols; ++u) {
      const double d = frame.truth.left(v, u);
      const double u_right = u - d;
      if (u_right < 4 || u_right > left.cols - 5) continue;
      if (std::abs(Between(frame.truth.right, v, u_right) - d) > 0.05) continue;
      if (std::abs(left(v, u + 1) - left(v, u - 1)) < 10) continue;
      sum += std::abs(left(v, u) - Between(right, v, u_right + shift));
      ++count;
    }
  }
  EXPECT_GT(count, static_cast<int>(left.total() / 4));
  return sum / count;
}

TEST(SyntheticDataset, ShowsTheSameColourInBothViews) {
  for (uint32_t seed : {1u, 2u, 3u}) {
    const DatasetFrame frame = Open("640x480", seed)->Get(25);
    const double here = MeanDifference(frame, 0);
    EXPECT_LT(here, 5) << seed;
    for (double shift : {-0.5, 0.5, -3.0, 3.0}) {
      EXPECT_GT(MeanDifference(frame, shift), 1.5 * here) << seed << " " << shift;
    }
  }
}

TEST(SyntheticDataset, HasSurfacesWithoutTexture) {
  const DatasetFrame frame = Open("640x480")->Get(0);
  const cv::Mat1b grey = ToGrey(frame.left);
  int smooth = 0;
  for (int v = 0; v < grey.rows; ++v) {
    for (int u = 4; u < grey.cols; ++u) {
      const auto [low, high] = std::minmax_element(&grey(v, u - 4), &grey(v, u) + 1);
      if (*high - *low <= 1) ++smooth;
    }
  }
  EXPECT_GT(smooth, static_cast<int>(grey.total() / 20));
  EXPECT_LT(smooth, static_cast<int>(grey.total() / 2));
}

TEST(SyntheticDataset, RendersSmallAndOddSizes) {
  for (const cv::Size size : {cv::Size(16, 16), cv::Size(17, 31), cv::Size(333, 17),
                              cv::Size(16, 700), cv::Size(1001, 16)}) {
    const auto source = Open(std::to_string(size.width) + "x" + std::to_string(size.height));
    const DatasetFrame frame = source->Get(5);
    EXPECT_EQ(frame.left.size(), size);
    EXPECT_EQ(frame.right.size(), size);
    EXPECT_EQ(frame.left.type(), CV_8UC3);
    EXPECT_EQ(frame.tof.depth_m.size(), cv::Size(size.width / 10, size.height / 10));
    for (const cv::Mat1f& truth : {frame.truth.left, frame.truth.right}) {
      ASSERT_EQ(truth.size(), size);
      for (float d : truth) ASSERT_TRUE(d > 0 && d < 0.2 * size.width) << size << d;
    }
  }
}

}  // namespace
}  // namespace sprout::scenes
