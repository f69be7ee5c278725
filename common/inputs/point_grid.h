#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <vector>

namespace sprout::inputs {

/// A range point in the left picture, px.
struct PicturePoint {
  float u, v;
  float disparity;  ///< d + c_x' − c_x
};

/// Points in the picture, in cells; for what lies around a position.
class PointGrid {
 public:
  /// @param points  inside the picture.
  PointGrid(std::vector<PicturePoint> points, cv::Size picture);

  /// The median disparity around a position, px, if there all points lie on one surface.
  /// @param at  in the picture.
  std::optional<double> SurfaceAt(const cv::Point2f& at);

 private:
  std::optional<double> MedianOfSurface(const cv::Point2f& aside);
  size_t Index(int x, int y) const {
    return static_cast<size_t>(y) * static_cast<size_t>(cells_.width) + static_cast<size_t>(x);
  }

  std::vector<PicturePoint> points_;
  float reach_;
  cv::Size cells_;
  std::vector<int> first_;
  std::vector<int> next_;
  std::vector<float> around_;
};

}  // namespace sprout::inputs
