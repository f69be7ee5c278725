#include "services/depth/flying.h"

#include <limits>
#include <opencv2/imgproc.hpp>

namespace sprout::depth {
namespace {

// Chosen on maps with truth (NOTES.md). Slants up to 2 kSame / (kSupport · (2 kReachPx + 1)) stay.
constexpr int kReachPx = 6;                             // how far a surface is at most
constexpr int kStep = DisparityImage::kCountsPerPixel;  // how much nearer or farther it is at least
constexpr int kSame = DisparityImage::kCountsPerPixel;  // largest difference on a surface
// A flying pixel has at most this share of the pixels around on its surface: a ramp from one
// surface to another has few, a slanted surface many.
constexpr double kSupport = 0.2;

constexpr int16_t kNoMinimum = std::numeric_limits<int16_t>::max();

// The largest and the smallest count of each pixel and those before or behind it, along one axis. A
// row without any has kInvalid and kNoMinimum.
struct Side {
  cv::Mat1s largest;
  cv::Mat1s smallest;
};

/// @param for_minimum  the counts, with kNoMinimum where there is none.
Side SideOf(const cv::Mat1s& counts, const cv::Mat1s& for_minimum, cv::Point towards) {
  const cv::Mat window =
      cv::Mat::ones(towards.x != 0 ? cv::Size(kReachPx + 1, 1) : cv::Size(1, kReachPx + 1), CV_8U);
  const cv::Point anchor =
      towards.x + towards.y > 0 ? cv::Point(0, 0) : cv::Point(window.cols - 1, window.rows - 1);
  Side side;
  cv::dilate(counts, side.largest, window, anchor, 1, cv::BORDER_CONSTANT,
             cv::Scalar(DisparityImage::kInvalid));
  cv::erode(for_minimum, side.smallest, window, anchor, 1, cv::BORDER_CONSTANT,
            cv::Scalar(kNoMinimum));
  return side;
}

// Pixels with a nearer one on one side and a farther one on the other.
void AddBetween(const cv::Mat1s& counts, const Side& one, const Side& other, cv::Mat1b& between) {
  for (int v = 0; v < counts.rows; ++v) {
    const int16_t* const own = counts[v];
    const int16_t* const largest = one.largest[v];
    const int16_t* const smallest = one.smallest[v];
    const int16_t* const other_largest = other.largest[v];
    const int16_t* const other_smallest = other.smallest[v];
    uint8_t* const found = between[v];
    for (int u = 0; u < counts.cols; ++u) {
      const int nearer = own[u] + kStep;
      const int farther = own[u] - kStep;
      const bool falls = (largest[u] >= nearer) & (other_smallest[u] <= farther);
      const bool rises = (smallest[u] <= farther) & (other_largest[u] >= nearer);
      if (falls | rises) found[u] = 255;
    }
  }
}

// Whether more than kSupport of the pixels around, of those that have a disparity, belong to the
// pixel's surface.
bool IsSupported(const cv::Mat1s& counts, cv::Point pixel) {
  constexpr int kSide = 2 * kReachPx + 1;
  const cv::Rect around = cv::Rect(pixel.x - kReachPx, pixel.y - kReachPx, kSide, kSide) &
                          cv::Rect({0, 0}, counts.size());
  const int own = counts(pixel);
  int found = 0;
  int supporting = 0;
  for (int v = around.y; v < around.br().y; ++v) {
    const int16_t* const row = counts[v];
    for (int u = around.x; u < around.br().x; ++u) {
      found += row[u] != DisparityImage::kInvalid ? 1 : 0;
      supporting += std::abs(row[u] - own) <= kSame ? 1 : 0;
    }
    if (supporting > kSupport * around.area()) return true;  // however many are found
  }
  return supporting > kSupport * found;
}

}  // namespace

cv::Mat1b FindFlying(const DisparityImage& map) {
  const cv::Mat1s& counts = map.counts();
  cv::Mat1s for_minimum = counts.clone();
  for_minimum.setTo(kNoMinimum, counts == DisparityImage::kInvalid);
  const auto side = [&](int x, int y) { return SideOf(counts, for_minimum, {x, y}); };
  cv::Mat1b flying(counts.size(), uint8_t{0});
  AddBetween(counts, side(-1, 0), side(1, 0), flying);
  AddBetween(counts, side(0, -1), side(0, 1), flying);
  cv::parallel_for_({0, flying.rows}, [&](const cv::Range& rows) {
    for (int v = rows.start; v < rows.end; ++v) {
      for (int u = 0; u < flying.cols; ++u) {
        if (flying(v, u) == 0) continue;
        if (!map.IsValid(u, v) || IsSupported(counts, {u, v})) flying(v, u) = 0;
      }
    }
  });
  return flying;
}

}  // namespace sprout::depth
