#include "services/refine/window_difference.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

namespace sprout::refine {
namespace {

constexpr int kRadius = 2;

// Compares before it converts, since a position may be far outside.
bool WindowFits(double u, double v, cv::Size size) {
  return u > kRadius - 0.5 && u < size.width - kRadius - 0.5 && v > kRadius - 0.5 &&
         v < size.height - kRadius - 0.5;
}

double Difference(const cv::Mat1b& left, const cv::Mat1b& right, cv::Point at_left,
                  cv::Point at_right) {
  int32_t differences = 0;
  int32_t squares = 0;
  for (int y = -kRadius; y <= kRadius; ++y) {
    const uint8_t* a = left.ptr(at_left.y + y) + at_left.x;
    const uint8_t* b = right.ptr(at_right.y + y) + at_right.x;
    for (int x = -kRadius; x <= kRadius; ++x) {
      differences += (a[x] - b[x]) * (a[x] - b[x]);
      squares += a[x] * a[x] + b[x] * b[x];
    }
  }
  return squares == 0 ? 0 : static_cast<double>(differences) / squares;
}

}  // namespace

double WindowDifference(const cv::Mat1b& left, const cv::Mat1b& right, double u, double v,
                        double u_right) {
  double best = std::numeric_limits<double>::infinity();
  if (!WindowFits(u, v, left.size())) return best;
  const int row = static_cast<int>(std::lround(v));
  const cv::Point at_left(static_cast<int>(std::lround(u)), row);
  for (const double shifted : {u_right - 1, u_right, u_right + 1}) {
    if (!WindowFits(shifted, v, right.size())) continue;
    const cv::Point at_right(static_cast<int>(std::lround(shifted)), row);
    best = std::min(best, Difference(left, right, at_left, at_right));
  }
  return best;
}

}  // namespace sprout::refine
