#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "common/core/tof_image.h"
#include "common/geometry/projection.h"

namespace sprout::refine {

/// A place where the ToF image steps from a near surface to a far one: the near one ends there.
struct TofEdge {
  Eigen::Vector2d left{0, 0};    ///< where it ends in the left image, px
  double near_px = 0;            ///< disparity of the near surface there, px
  double far_px = 0;             ///< of the far one
  double near_slope = 0;         ///< change of the near disparity along the normal, px a px
  double far_slope = 0;          ///< of the far one
  Eigen::Vector2d normal{1, 0};  ///< across the edge in the images, from near to far; of length 1
  /// How far the edge moves along its normal, px, when the ToF camera is turned about its own place
  /// such that its points move in the middle of the left image by 1 px to the right; by 1 px down.
  Eigen::Vector2d motion{1, 0};
};

/// Finds the depth edges of ToF images. Keeps its memory from frame to frame, 8 bytes a ToF pixel.
class TofEdgeFinder {
 public:
  /// Along every row and every column of the ToF image: two pixels on one surface, then up to three
  /// that see both, then two on another surface that is farther by `least_px`. How much of each
  /// mixed pixel the near surface fills follows from its depth, eq. (A2). Edges that make less than
  /// 37° with the row (column) are left to the columns (rows).
  /// @param points    of `tof`, projected, at most one a ToF pixel.
  /// @param tof       gives the amplitudes; without them both surfaces count as equally bright.
  /// @param least_px  smallest step of the disparity; > 0.
  /// @returns those inside the left image, in the order of the points; valid until the next call.
  /// O(ToF pixels), about 30 ns each.
  std::span<const TofEdge> Find(std::span<const ProjectedPoint> points, const TofImage& tof,
                                const TofProjector& projector, double least_px);

 private:
  struct Line;
  struct Step;
  struct Direction;
  struct View;

  static std::optional<Step> StepAlong(const Line& line, double least_px);
  std::optional<Eigen::Vector2d> NormalAt(const float* centre, double between_px) const;
  void SetImage(std::span<const ProjectedPoint> points, const TofImage& tof,
                const TofCamera& camera);
  size_t IndexOf(const ProjectedPoint& point) const;
  std::optional<TofEdge> EdgeAt(const ProjectedPoint& point, const Direction& direction,
                                const View& view, double least_px) const;

  std::ptrdiff_t stride_ = 0;
  std::vector<float> disparity_;  // of the ToF pixels and a border, NaN = none
  std::vector<float> amplitude_;
  std::vector<TofEdge> edges_;
};

}  // namespace sprout::refine
