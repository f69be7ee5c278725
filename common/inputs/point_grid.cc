#include "common/inputs/point_grid.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/core/quantile.h"

namespace sprout::inputs {
namespace {

struct PointGridRules {
  static constexpr double kReach = 1.5;    ///< of a match's neighbours, in spacings of points
  static constexpr size_t kMinAround = 3;  ///< points around a match
  static constexpr size_t kMaxAround = 64;
  /// Their middle may lie so far beside the match, px: beside a beam of a lidar the disparity of a
  /// road changes by a third of a pixel a row (baseline / height of the cameras).
  static constexpr float kMaxAside = 4;
  static constexpr float kMaxAsideShare = 0.15F;  ///< or of the reach
  static constexpr double kOneSurface = 0.12;     ///< most by which their disparities differ, share
};

}  // namespace

PointGrid::PointGrid(std::vector<PicturePoint> points, cv::Size picture)
    : points_(std::move(points)) {
  const auto count = static_cast<double>(std::max<size_t>(1, points_.size()));
  reach_ =
      static_cast<float>(PointGridRules::kReach * std::max(1.0, std::sqrt(picture.area() / count)));
  cells_ = cv::Size(static_cast<int>(static_cast<float>(picture.width) / reach_) + 1,
                    static_cast<int>(static_cast<float>(picture.height) / reach_) + 1);
  first_.assign(static_cast<size_t>(cells_.area()), -1);
  next_.resize(points_.size());
  for (size_t i = 0; i < points_.size(); ++i) {
    int& first = first_[Index(static_cast<int>(points_[i].u / reach_),
                              static_cast<int>(points_[i].v / reach_))];
    next_[i] = first;
    first = static_cast<int>(i);
  }
}

std::optional<double> PointGrid::SurfaceAt(const cv::Point2f& at) {
  around_.clear();
  cv::Point2f aside(0, 0);
  const int column = static_cast<int>(at.x / reach_);
  const int row = static_cast<int>(at.y / reach_);
  for (int y = std::max(0, row - 1); y <= std::min(cells_.height - 1, row + 1); ++y) {
    for (int x = std::max(0, column - 1); x <= std::min(cells_.width - 1, column + 1); ++x) {
      for (int i = first_[Index(x, y)]; i >= 0; i = next_[static_cast<size_t>(i)]) {
        const PicturePoint& point = points_[static_cast<size_t>(i)];
        const float du = point.u - at.x;
        const float dv = point.v - at.y;
        if (du * du + dv * dv > reach_ * reach_) continue;
        around_.push_back(point.disparity);
        aside += cv::Point2f(du, dv);
        if (around_.size() == PointGridRules::kMaxAround) return MedianOfSurface(aside);
      }
    }
  }
  return MedianOfSurface(aside);
}

// @param aside  sum of the points' offsets from the match.
std::optional<double> PointGrid::MedianOfSurface(const cv::Point2f& aside) {
  if (around_.size() < PointGridRules::kMinAround) return {};
  const float allowed =
      std::max(PointGridRules::kMaxAside, PointGridRules::kMaxAsideShare * reach_);
  const auto count = static_cast<float>(around_.size());
  if (cv::norm(aside) > allowed * count) return {};
  const auto [least, most] = std::ranges::minmax_element(around_);
  if (*most - *least > PointGridRules::kOneSurface * *most) return {};
  return Median(around_);
}

}  // namespace sprout::inputs
