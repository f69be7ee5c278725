#include "services/depth/flying.h"

#include <limits>
#include <opencv2/imgproc.hpp>

namespace sprout::depth {
namespace {

constexpr int16_t kNoMinimum = std::numeric_limits<int16_t>::max();

// The largest and the smallest count of each pixel and those before or behind it, along one axis. A
// row without any has kInvalid and kNoMinimum.
struct Side {
  cv::Mat1s largest;
  cv::Mat1s smallest;
};

/// @param for_minimum  the counts, with kNoMinimum where there is none.
Side SideOf(const cv::Mat1s& counts, const cv::Mat1s& for_minimum, cv::Point towards, int reach) {
  const cv::Mat window =
      cv::Mat::ones(towards.x != 0 ? cv::Size(reach + 1, 1) : cv::Size(1, reach + 1), CV_8U);
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
void AddBetween(const cv::Mat1s& counts, const Side& one, const Side& other, int step,
                cv::Mat1b& between) {
  for (int v = 0; v < counts.rows; ++v) {
    const int16_t* const own = counts[v];
    const int16_t* const largest = one.largest[v];
    const int16_t* const smallest = one.smallest[v];
    const int16_t* const other_largest = other.largest[v];
    const int16_t* const other_smallest = other.smallest[v];
    uint8_t* const found = between[v];
    for (int u = 0; u < counts.cols; ++u) {
      const int nearer = own[u] + step;
      const int farther = own[u] - step;
      const bool falls = (largest[u] >= nearer) & (other_smallest[u] <= farther);
      const bool rises = (smallest[u] <= farther) & (other_largest[u] >= nearer);
      if (falls | rises) found[u] = 255;
    }
  }
}

// Whether more than a share of the pixels around, of those that have a disparity, belong to the
// pixel's surface.
bool IsSupported(const cv::Mat1s& counts, cv::Point pixel, int reach, int same, double share) {
  const cv::Rect around = cv::Rect(pixel.x - reach, pixel.y - reach, 2 * reach + 1, 2 * reach + 1) &
                          cv::Rect({0, 0}, counts.size());
  const int own = counts(pixel);
  int found = 0;
  int supporting = 0;
  for (int v = around.y; v < around.br().y; ++v) {
    const int16_t* const row = counts[v];
    for (int u = around.x; u < around.br().x; ++u) {
      found += row[u] != DisparityImage::kInvalid ? 1 : 0;
      supporting += std::abs(row[u] - own) <= same ? 1 : 0;
    }
    if (supporting > share * around.area()) return true;  // however many are found
  }
  return supporting > share * found;
}

}  // namespace

cv::Mat1b FindFlying(const DisparityImage& map, const FlyingRule& rule) {
  const cv::Mat1s& counts = map.counts();
  cv::Mat1s for_minimum = counts.clone();
  for_minimum.setTo(kNoMinimum, counts == DisparityImage::kInvalid);
  const auto side = [&](int x, int y) {
    return SideOf(counts, for_minimum, {x, y}, rule.reach_px);
  };
  const int step = ToCounts(rule.step_px);
  cv::Mat1b flying(counts.size(), uint8_t{0});
  AddBetween(counts, side(-1, 0), side(1, 0), step, flying);
  AddBetween(counts, side(0, -1), side(0, 1), step, flying);
  const int same = ToCounts(rule.same_px);
  cv::parallel_for_({0, flying.rows}, [&](const cv::Range& rows) {
    for (int v = rows.start; v < rows.end; ++v) {
      for (int u = 0; u < flying.cols; ++u) {
        if (flying(v, u) == 0) continue;
        const bool alone =
            map.IsValid(u, v) && !IsSupported(counts, {u, v}, rule.reach_px, same, rule.support);
        if (!alone) flying(v, u) = 0;
      }
    }
  });
  return flying;
}

}  // namespace sprout::depth
