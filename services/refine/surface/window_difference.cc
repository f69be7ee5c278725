#include "services/refine/surface/window_difference.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/core/window_sums.h"
#include "services/refine/surface/surface_rules.h"

namespace sprout::refine {
namespace {

double Difference(const cv::Mat1b& left, const cv::Mat1b& right, cv::Point at_left,
                  cv::Point at_right) {
  const WindowSums sums = SumWindows<SurfaceRules::kRadius>(left, right, at_left, at_right);
  const int32_t squares = sums.left_squares + sums.right_squares;
  return squares == 0 ? 0 : static_cast<double>(squares - 2 * sums.products) / squares;
}

}  // namespace

double WindowDifference(const cv::Mat1b& left, const cv::Mat1b& right, double u, double v,
                        double u_right) {
  double best = std::numeric_limits<double>::infinity();
  constexpr double kMargin = SurfaceRules::kRadius - 0.5;
  if (!IsInside(u, v, left.size(), kMargin)) return best;
  const int row = static_cast<int>(std::lround(v));
  const cv::Point at_left(static_cast<int>(std::lround(u)), row);
  for (const double shifted : {u_right - 1, u_right, u_right + 1}) {
    if (!IsInside(shifted, v, right.size(), kMargin)) continue;
    const cv::Point at_right(static_cast<int>(std::lround(shifted)), row);
    best = std::min(best, Difference(left, right, at_left, at_right));
  }
  return best;
}

}  // namespace sprout::refine
