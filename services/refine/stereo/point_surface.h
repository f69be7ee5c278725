#pragma once

#include <array>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/core/types.hpp>
#include <span>
#include <vector>

#include "common/core/seed.h"

namespace sprout::refine {

/// Square cells over the left image.
struct CellGrid {
  double spacing_px;  ///< side of a cell, px
  cv::Size size;      ///< cells

  CellGrid(double spacing, cv::Size image)
      : spacing_px(spacing), size(At(image.width - 1) + 1, At(image.height - 1) + 1) {}

  /// The column or row of cells that a position lies in.
  int At(double position) const {
    return static_cast<int>(std::floor((position + 0.5) / spacing_px));
  }

  cv::Point CellOf(double u, double v) const { return {At(u), At(v)}; }

  /// Whether a cell is one of the grid, as that of a position outside the image is not.
  bool Has(cv::Point cell) const { return cv::Rect({}, size).contains(cell); }

  /// The middle of a cell, px of the image.
  cv::Point2d CentrePx(cv::Point cell) const {
    return {(cell.x + 0.5) * spacing_px - 0.5, (cell.y + 0.5) * spacing_px - 0.5};
  }
};

/// How well the points of a range sensor explain what lies between them: the standard deviation of
/// an interpolation at the centres of square cells of the left image, eqs. (M1) and (M2) of the
/// README. It follows from how far the points around are, and from whether their planes agree.
class PointSurface {
 public:
  /// @param seeds  of the range sensor; must live as long as SigmaPx() is called.
  /// @param asked  of the grid's size: nonzero where SigmaPx() and OffPx() will be called; empty:
  ///               everywhere.
  /// O(cells + seeds around those); on OpenCV's threads, with the same result for any number. Keeps
  /// its memory, 20 bytes a cell.
  void Set(std::span<const Seed> seeds, const CellGrid& grid, const cv::Mat1b& asked = {});

  /// Standard deviation of the disparity that the points around a cell give for its centre, px;
  /// infinite when there are no points.
  /// O(1); thread-safe.
  double SigmaPx(cv::Point cell) const;

  /// The least difference, px, between a disparity and what the planes of the points around a cell
  /// are at its centre; infinite when there are no points. O(1); thread-safe.
  double OffPx(cv::Point cell, double disparity_px) const;

 private:
  static constexpr int kNone = -1;
  static constexpr size_t kSectors = 4;
  // The nearest seed in each of four sectors around a cell, or kNone.
  using Around = std::array<int, kSectors>;

  const Seed& SeedOf(int index) const { return seeds_[static_cast<size_t>(index)]; }
  double Distance(int index, cv::Point cell) const;
  void PutIntoCells();
  void FindNearest(size_t quadrant);
  void FindSlopes(const cv::Mat1b& asked);
  Around AroundCell(cv::Point cell) const;
  cv::Point2d SlopeAt(const Seed& seed, const Around& around) const;

  std::span<const Seed> seeds_;
  CellGrid grid_{1, {1, 1}};
  cv::Mat1i own_;  // the seed in a cell, of several the one in the middle
  std::array<cv::Mat1i, kSectors> quadrant_;  // the nearest seed there, the cell's own included
  std::vector<cv::Point2d> slopes_;           // at the seeds around what is asked, px a px
};

}  // namespace sprout::refine
