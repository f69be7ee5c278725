#pragma once

#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "common/config/config.h"
#include "common/core/seed.h"
#include "services/refine/stereo/point_surface.h"
#include "services/refine/stereo/stereo_matcher.h"
#include "services/refine/stereo/stereo_rules.h"

namespace sprout::refine {

/// Finds seeds in the pair itself where the range sensor gives nothing: on a grid of the wanted
/// spacing, every cell without a ToF point nearby gets a disparity from StereoMatcher.
///
/// A seed is taken only from inside a surface: pixels beside a depth edge, whose windows show
/// two surfaces, are left out, and so are places without texture, where no disparity is unique.
class StereoSeedFinder {
 public:
  /// @throws ConfigError when a value is out of range.
  explicit StereoSeedFinder(const RefineConfig& config);

  /// @param left, right  rectified pair, grey, of one size.
  /// @param seeds        of the range sensor; disparities far from them cost more.
  /// @param covered      positions in the left image that need no seed of stereo: of ToF points,
  ///                     whether or not they became seeds, but not of those on dark regions.
  /// @param spacing_px   between the sensor's points, along its rows or columns, the larger; 0: it
  ///                     has none.
  /// @param most_px      of each cell of the CellGrid of SpacingPx(), the largest disparity that a
  ///                     seed may have; empty: any.
  /// @returns at most one seed a cell, row by row, with whole windows in both images, each with the
  ///          standard deviation that the disparities around it show; valid until the next call.
  /// O(pixels without ToF points); no I/O; on OpenCV's threads, with the same result for any
  /// number. Keeps its memory from frame to frame.
  std::span<const Seed> Find(const cv::Mat1b& left, const cv::Mat1b& right,
                             std::span<const Seed> seeds, std::span<const cv::Point2f> covered,
                             double spacing_px, const cv::Mat1f& most_px = {});

  /// The seeds of the last call.
  std::span<const Seed> found() const { return seeds_; }

  /// How many cells of the last call wanted a seed and got none, and are farther than a spacing
  /// from the points, which show themselves if disparities there are negative.
  size_t unanswered() const { return unanswered_; }

  /// Matches of a few pixels, see kFewPixels, for a first look: positions and disparities are good
  /// to about half a px of what they were matched on, `error_px`. A tenth of Find()'s time without
  /// points; valid until the next call of any.
  /// @param step  above 0: of every so many of its rows and columns.
  std::span<const Seed> FindCoarse(const cv::Mat1b& left, const cv::Mat1b& right, double& error_px,
                                   int step = StereoRules::kCoarseStep);

  /// The share of matches whose disparity is, or may be, negative down to −columns. Images are
  /// halved until they have kFewPixels with so many more columns; a disparity of up to half of one
  /// of their px counts, too. A tenth of Find()'s time without points.
  double ShareBelowZero(const cv::Mat1b& left, const cv::Mat1b& right, int columns);

  /// The images of the next calls are so many columns wider than the cameras', and all disparities
  /// larger (see Widened()): the search reaches as much farther.
  void SetColumns(int columns) { columns_ = columns; }

  /// The disparity of a point at infinity in the next calls, px, ≥ 0: without
  /// stereo_max_disparity_px the search reaches as much farther.
  void SetInfinity(int disparity_px) { infinity_px_ = disparity_px; }

  /// How far columns of the pair may be off in the next calls of Find(), px: an error that all
  /// seeds share.
  void SetColumnError(double px) { column_error_px_ = px; }

  /// The search of the next calls reaches at least so far, px, if stereo_max_disparity_px is 0: as
  /// far as what range points show is near.
  void SetReach(int disparity_px) { reach_px_ = disparity_px; }

  /// What was set.
  int reach_px() const { return reach_px_; }

  /// The largest disparity that is searched in images of this width, px.
  int MostDisparityPx(int width) const { return SettingsFor(width, columns_).max_disparity_px; }

  /// Side of the cells of an image of this width, px.
  double SpacingPx(int width) const;

  /// Whether points so far apart leave cells between them in an image of this width.
  bool IsCoarse(double spacing_px, int width) const;

 private:
  StereoMatcherSettings SettingsFor(int width, int columns) const;
  void FindUncovered(const CellGrid& grid, std::span<const Seed> seeds,
                     std::span<const cv::Point2f> covered, double gap, double scale);
  size_t CountUnanswered(const CellGrid& grid, double spacing_px);
  void MarkWanted(const CellGrid& grid, cv::Size size, int settle_cells);
  void TakeFrom(const cv::Mat1b& left, const cv::Mat1b& right, const CellGrid& grid,
                const cv::Mat1f& disparity_px, const cv::Mat1f& most_px, int row);

  RefineConfig config_;
  int columns_ = 0;
  int infinity_px_ = 0;
  double column_error_px_ = 0;
  int reach_px_ = 0;
  StereoMatcher matcher_;
  PointSurface points_;
  cv::Mat1b with_points_;                 // cells that hold covered positions
  cv::Mat1b uncovered_;                   // cells that want a seed
  cv::Mat1b wanted_;                      // pixels that are matched for them
  std::vector<std::vector<Seed>> found_;  // in the rows of the grid
  std::vector<Seed> seeds_;
  size_t unanswered_ = 0;
};

}  // namespace sprout::refine
