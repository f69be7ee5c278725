#ifndef SPROUT_SERVICES_REFINE_RANGE_RANGE_NODES_H_
#define SPROUT_SERVICES_REFINE_RANGE_RANGE_NODES_H_

#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "common/core/rig.h"
#include "common/geometry/projection.h"
#include "services/refine/range/range_costs.h"
#include "services/refine/surface/tof_surface.h"

namespace sprout::refine {

/// One frame, for the estimate of the range sensor's error.
struct RangeInput {
  const cv::Mat1b& left;  ///< rectified pair, grey
  const cv::Mat1b& right;
  const Rig& rig;
  const TofSurface& surface;  ///< of the points
  double noise_px = 0;        ///< standard deviation of the points' noise
  bool coarse = false;        ///< whether slopes between points are not known, as with few beams
};

/// A range point whose surface is compared in both images.
struct RangeNode {
  cv::Point cell;        ///< of RangeNodes
  cv::Point2d at;        ///< in the left image, px
  double disparity = 0;  ///< as measured, px
  cv::Point2d slope;     ///< of its surface, px a px
  bool whole = true;     ///< no depth edge is beside it
  double noise = 0;      ///< variance of the left image around it that may be noise, grey levels²
  OffsetCosts costs;

  double DisparityAt(const cv::Point2d& x) const {
    return disparity + slope.x * (x.x - at.x) + slope.y * (x.y - at.y);
  }
};

/// Whether a point with that disparity lies on the node's surface.
bool IsOnSurface(const RangeNode& node, const cv::Point2d& at, double disparity);

/// Whether two nodes lie on one surface: one of both planes meets the other node.
bool ShareSurface(const RangeNode& a, const RangeNode& b);

/// A grid over the range image. Each cell has one point at most: the one with most texture.
class RangeNodes {
 public:
  /// @param points  those of input.surface. Those that a nearer surface hides, or that lie beside
  ///                one, are left out: their windows show two surfaces.
  /// O(points); on OpenCV's threads.
  void Set(const RangeInput& input, std::span<const ProjectedPoint> points);

  cv::Size size() const { return size_; }
  std::span<const RangeNode> nodes() const { return nodes_; }
  /// The node of a cell; −1: none, also outside the grid.
  int At(int x, int y) const {
    return x < 0 || y < 0 || x >= size_.width || y >= size_.height ? -1 : index_(y, x);
  }
  /// Where a point lies, in cells; the middle of cell (0, 0) is (0, 0).
  cv::Point2d CellOf(const TofSurface& surface, const ProjectedPoint& point) const {
    const cv::Point cell = surface.CellOf(point);
    return {(cell.x + 0.5) / side_ - 0.5, (cell.y + 0.5) / side_ - 0.5};
  }

 private:
  int side_ = 1;  // of a cell, in cells of the surface
  cv::Size size_;
  // The nearest surface in each cell of an image, half a spacing wide.
  struct View {
    cv::Mat1f nearest;
    double wide = 1, high = 1;

    void Set(const RectifiedPair& pair, const TofSurface& surface,
             std::span<const ProjectedPoint> points, float Seed::*column);
    bool Hides(double u, double v, double disparity, double tolerance_px) const;
  };

  static void Compare(const cv::Mat1b& left, const cv::Mat1b& right, std::vector<RangeNode>& nodes);

  cv::Mat1i index_;
  cv::Mat1f texture_;
  View left_;
  View right_;
  std::vector<RangeNode> nodes_;
};

}  // namespace sprout::refine

#endif  // SPROUT_SERVICES_REFINE_RANGE_RANGE_NODES_H_
