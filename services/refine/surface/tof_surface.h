#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <opencv2/core.hpp>
#include <optional>
#include <span>
#include <vector>

#include "common/geometry/projection.h"
#include "services/refine/surface/cell_lists.h"
#include "services/refine/surface/range_noise.h"
#include "services/refine/surface/surface_rules.h"

namespace sprout::refine {

/// How much the 5×5 windows around two corresponding pixels differ: the sum of squared differences
/// over the sum of squares, 0 (equal) to 1. The right column may be one pixel off either way, since
/// a ToF point is not more exact: the best of the three counts.
///
/// @param left, right  rectified pair, grey, of one size.
/// @param u, v, u_right  position, px; rounded to whole pixels.
/// @returns infinity when the window leaves the left image, or the right one in all three places.
double WindowDifference(const cv::Mat1b& left, const cv::Mat1b& right, double u, double v,
                        double u_right);

/// The tolerances of TofSurface::FindHidden().
struct HiddenRule {
  double core = 0;          ///< distance at which the odds have halved, sizes of a piece
  double reach = 0;         ///< how far a piece reaches, sizes of a piece
  double tolerance_px = 0;  ///< how much further a point may lie, px
};

/// Whether a nearer surface lies before a point.
struct Hidden {
  bool from_left = false;   ///< in the left image
  bool from_right = false;  ///< in the right one

  bool operator==(const Hidden&) const = default;
};

/// The surface that a ToF image shows, as disparities (px) at its cells, and two tests of its
/// points against it. Each looks at the neighbours of a point only. A cell is a ToF pixel, or as
/// many as lie between returns: for three of four returns the next one, along its row and along its
/// column, lies in the next cell. So the scan of a lidar, which fills few pixels of its image, is a
/// surface as well. Keeps its memory when it is set again: about 40 bytes a ToF pixel, and 8 a cell
/// of FindHidden().
class TofSurface {
 public:
  /// A surface without points.
  TofSurface() = default;

  TofSurface(const Rig& rig, std::span<const ProjectedPoint> points) { Set(rig, points); }

  /// @param points  of one ToF image, at most one a pixel.
  /// O(ToF pixels).
  void Set(const Rig& rig, std::span<const ProjectedPoint> points);

  /// Distance from one cell to the next in the left image, px; the longer side.
  double spacing_px() const { return std::max(column_px_, row_px_); }
  double column_px() const { return column_px_; }  ///< along the rows
  double row_px() const { return row_px_; }        ///< along the columns

  /// Whether each cell is a ToF pixel, as of a camera; a lidar's scan has larger ones.
  bool has_pixels() const { return column_step_ == 1 && row_step_ == 1; }

  /// Columns and rows of cells, and the cell of a point.
  int columns() const { return static_cast<int>(stride_) - 2; }
  int rows() const { return rows_; }
  cv::Point CellOf(const ProjectedPoint& point) const {
    return {point.tof_u / column_step_, point.tof_v / row_step_};
  }

  /// Disparity of the nearest point in a cell, px; NaN: none.
  /// @pre the cell lies among columns() and rows().
  float DisparityAt(const cv::Point& cell) const {
    return disparity_[static_cast<size_t>((cell.y + 1) * stride_ + cell.x + 1)];
  }

  /// A plane through the cells around a point, px of disparity and px a px.
  struct Plane {
    double disparity = 0;  ///< at the point
    cv::Point2d slope;
    /// Whether cells around lie before or behind it.
    bool has_nearer = false, has_farther = false;
  };

  /// The least-squares plane through those of a point's 3×3 cells that lie within `tolerance_px` of
  /// the plane of its gentlest steps, which does not lead across a depth edge.
  /// @param point  one of those that the surface was made of.
  /// O(1); thread-safe.
  Plane PlaneOf(const ProjectedPoint& point, double tolerance_px) const;

  /// Standard deviation of the points' disparities, estimated from how far they lie from the mean
  /// of the neighbours on either side: along the axis where that is more, since rows, columns or
  /// beams may each have an error of their own. 0 when they show none.
  /// @param points  those that the surface was made of.
  /// O(ToF pixels) at the first call, then O(1).
  const RangeNoise& Noise(std::span<const ProjectedPoint> points);

  /// Standard deviation of a point's disparity, px: that of the frame's noise, or of the block of
  /// cells around the point where it is far noisier.
  /// @param noise  what Noise() returned, of the same points.
  /// O(1); thread-safe.
  double NoisePxAt(const ProjectedPoint& point, const RangeNoise& noise) const;

  /// Whether a point is isolated: fewer than two of the eight cells around have a
  /// disparity within `tolerance_px`. Flying pixels, whose light comes from two surfaces so that
  /// they lie on neither, and outliers of the noise.
  /// @param point  one of those that the surface was made of.
  /// O(1); thread-safe.
  bool IsIsolated(const ProjectedPoint& point, double tolerance_px) const;

  /// Whether the images confirm a point: its windows differ at most half as much at its own
  /// disparity as at that of any of the eight neighbours at another disparity, and there is such a
  /// neighbour. A point on an object smaller than a cell is isolated as a flying pixel is, but
  /// real.
  /// @param left, right  the rectified pair, grey.
  /// O(1); thread-safe.
  bool IsConfirmed(const ProjectedPoint& point, double tolerance_px, const cv::Mat1b& left,
                   const cv::Mat1b& right) const;

  /// Which points a nearer surface hides from the left or from the right camera: what the ToF
  /// camera sees past an edge from its own position. Each point stands for a piece of surface
  /// around it in the image, with the slant that its neighbours show. Whether such a piece hides a
  /// point that lies further by more than the tolerance is decided by odds, eq. (R1) of the
  /// README: those before the images are asked rise with the distance behind the piece and fall
  /// with the distance beside its point; the images say whether the piece's disparity or the
  /// point's own fits better. So a point that they confirm at its own place is not hidden.
  ///
  /// The idea of the paper's background rule, whose window of 5×5 px is too small for a sensor
  /// with fewer pixels and too large for one with more: here the window follows the spacing of the
  /// seeds, and the slant is subtracted, since over such a distance a slant would look like an
  /// edge.
  /// @param points  those that are tested and that hide others; a part of those that the surface
  ///                was made of, all inside the left image.
  /// @param in_both  how many of them, the first ones, lie in the right image as well; the others
  ///                neither hide nor are hidden there.
  /// @param left, right  the rectified pair, grey.
  /// @param rule    with a reach of 0 none is hidden.
  /// @returns one answer a point; valid until the next call. Does not depend on the order of the
  /// points.
  /// O(points + image pixels), whatever the points: of those that crowd into a pixel (a cell of
  /// half a px, or of a piece's reach) only the 32 nearest hide others, so a point is compared with
  /// 288 at most. On OpenCV's threads, with the same result for any number.
  const std::vector<Hidden>& FindHidden(std::span<const ProjectedPoint> points, size_t in_both,
                                        const cv::Mat1b& left, const cv::Mat1b& right,
                                        const HiddenRule& rule);

 private:
  // A point as a piece of surface.
  struct Piece {
    float disparity = 0;
    cv::Point2f slope;   // px of disparity a px of the left image, to the right and down
    cv::Point2f unseen;  // what it may be where no neighbour shows it, else 0
  };
  // One of the images of the pair.
  struct View {
    std::vector<cv::Point2f> positions;  // of the points
    CellLists cells;
  };
  class HiddenTest;

  static constexpr float kNone = std::numeric_limits<float>::quiet_NaN();  // of an empty cell

  // The smaller of two slopes by magnitude: beside an edge the one that stays on the surface. A
  // slope to a cell without a point is NaN and does not count.
  static float Gentler(float a, float b) {
    if (std::isnan(a)) return b;
    if (std::isnan(b)) return a;
    return std::abs(a) <= std::abs(b) ? a : b;
  }
  int RowStep(const TofCamera& tof, std::span<const ProjectedPoint> points, int columns);
  void SetSteps(const TofCamera& tof, std::span<const ProjectedPoint> points);
  double PointsPerCell(const TofCamera& tof, std::span<const ProjectedPoint> points);
  // Index of the cell in which a point lies.
  size_t IndexOf(const ProjectedPoint& point) const {
    return static_cast<size_t>((point.tof_v / row_step_ + 1) * stride_ +
                               point.tof_u / column_step_ + 1);
  }
  size_t BlockOf(const ProjectedPoint& point) const {
    const cv::Point block = CellOf(point) / SurfaceRules::kBlockCells;
    return static_cast<size_t>(block.y * (columns() / SurfaceRules::kBlockCells + 1) + block.x);
  }
  const float* At(const ProjectedPoint& point) const { return disparity_.data() + IndexOf(point); }
  // The cell of a point among those for pieces, which are as high as from one beam to the next.
  size_t PieceCell(const ProjectedPoint& point) const {
    return static_cast<size_t>((point.tof_v / next_row_ + 1) * stride_ +
                               point.tof_u / column_step_ + 1);
  }
  void SortForPieces(std::span<const ProjectedPoint> points);
  Piece PieceOf(std::span<const ProjectedPoint> points, const ProjectedPoint& point) const;

  cv::Size size_;        // of the images of the pair
  int column_step_ = 1;  // sides of a cell, ToF pixels
  int row_step_ = 1;
  double column_px_ = 1;  // the same in the images of the pair, px
  double row_px_ = 1;
  int next_row_ = 1;        // from one beam to the next, ToF pixels
  double next_row_px_ = 1;  // in the images of the pair, px
  int tof_rows_ = 0;
  double infinity_px_ = 0;      // disparity of what is infinitely far
  cv::Point2d piece_px_{1, 1};  // size of a piece, px
  std::ptrdiff_t stride_ = 0;
  int rows_ = 0;
  std::vector<float> disparity_;  // of the cells and one more all around, NaN = none
  std::vector<int> last_row_;     // with a return in each ToF column
  std::vector<int> gaps_;
  std::vector<uint8_t> filled_;  // cells with a point
  std::vector<Deviation> deviations_;
  std::optional<RangeNoise> noise_;       // once it was asked for
  std::vector<double> block_noise_px_;    // the same
  std::vector<int32_t> nearest_of_cell_;  // index of a point, −1 = none; cells for pieces
  std::vector<Piece> pieces_;
  View left_;
  View right_;
  std::vector<Hidden> hidden_;
};

}  // namespace sprout::refine
