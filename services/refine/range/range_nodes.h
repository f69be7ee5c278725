#pragma once

#include <array>
#include <cmath>
#include <cstdint>
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
  bool coarse = false;        ///< whether points are far apart, as with few beams
};

/// A range point whose surface is compared in both images.
struct RangeNode {
  cv::Point cell;        ///< of RangeNodes
  cv::Point2d at;        ///< in the left image, px
  double disparity = 0;  ///< as measured, px
  cv::Point2d slope;     ///< of its surface, px a px
  bool whole = true;     ///< no depth edge is beside it
  double noise = 0;      ///< variance of the left image around it that may be noise, grey levels²
  OffsetMoments moments;
  OffsetCosts costs{};
  float distinctness = 0;  ///< of the costs
  float max_vote = 1;      ///< what a higher cost counts as for the curve

  double DisparityAt(const cv::Point2d& x) const {
    return disparity + slope.x * (x.x - at.x) + slope.y * (x.y - at.y);
  }
};

/// How distinct a node's least cost is, 0 to 1: the median less the least.
float DistinctnessOf(const OffsetCosts& costs);

/// Whether a point with that disparity lies on the node's surface.
inline bool IsOnSurface(const RangeNode& node, const cv::Point2d& at, double disparity) {
  const cv::Point2d way = at - node.at;
  const double off = std::abs(node.DisparityAt(at) - disparity);
  return off <= RangeRules::kSurfacePx ||
         off <= RangeRules::kSurfacePx + RangeRules::kSurfacePerPx * std::sqrt(way.dot(way));
}

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
  /// Variance of the images' noise, grey levels².
  double noise() const { return noise_; }
  /// The node of a cell; −1: none, also outside the grid.
  int At(int x, int y) const {
    return x < 0 || y < 0 || x >= size_.width || y >= size_.height ? -1 : index_(y, x);
  }
  /// Finds out which nodes side by side share a surface.
  void Link();
  /// The nodes of the 3×3 cells around a node that share its surface, itself included, row by row.
  /// Call Link() before.
  std::span<const uint32_t> SurfaceAround(size_t node) const {
    return std::span(links_[node].around).first(links_[node].count);
  }
  bool AreOneSurface(size_t a, size_t b) const;
  /// How offsets of all nodes change around one on its surface, px a px: the slope of the
  /// least-squares plane. Call Link() before.
  cv::Point2d SlopeOf(size_t node, std::span<const double> offsets_px) const;
  /// Compares the images again, at all nodes moved by offsets. Their disparities stay as measured.
  /// Call Link() before. O(nodes); on OpenCV's threads.
  void Move(const RangeInput& input, std::span<const double> offsets_px);
  /// By how many standard deviations the images differ more at these nodes than at those of the
  /// same cells in another grid of as many points. 0 where there are none.
  double SigmasWorseThan(const RangeNodes& others) const;

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

  void Offer(const RangeInput& input, const ProjectedPoint& point, size_t index);
  void Compare(const cv::Mat1b& left, const cv::Mat1b& right);
  void SetCosts(RangeNode& node) const;

  // The nodes of the 3×3 cells around one that share its surface: `count` of them, and a bit each.
  struct Links {
    std::array<uint32_t, 9> around;
    uint32_t count;
    uint32_t bits;
  };
  static unsigned BitOf(const cv::Point& way) { return 1U << ((way.y + 1) * 3 + way.x + 1); }

  cv::Mat1i index_;
  cv::Mat1f texture_;
  View left_;
  View right_;
  std::vector<TofSurface::Plane> planes_;  // of those points that were best in their cells
  std::vector<RangeNode> nodes_;
  double noise_ = RangeRules::kMinNoise;
  std::vector<Links> links_;
};

/// Clears the flags of nodes that have fewer than `fewest` flagged nodes side by side on one
/// surface. Call nodes.Link() before.
inline void KeepPatches(const RangeNodes& nodes, size_t fewest, std::vector<uint8_t>& flags) {
  std::vector<uint8_t> todo = flags;
  std::vector<size_t> patch;
  for (size_t i = 0; i < flags.size(); ++i) {
    if (todo[i] == 0) continue;
    patch = {i};
    todo[i] = 0;
    for (size_t next = 0; next < patch.size(); ++next) {
      for (const uint32_t other : nodes.SurfaceAround(patch[next])) {
        if (todo[other] == 0) continue;
        todo[other] = 0;
        patch.push_back(other);
      }
    }
    if (patch.size() >= fewest) continue;
    for (const size_t node : patch) flags[node] = 0;
  }
}

}  // namespace sprout::refine
