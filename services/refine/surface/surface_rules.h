#ifndef SPROUT_SERVICES_REFINE_SURFACE_SURFACE_RULES_H_
#define SPROUT_SERVICES_REFINE_SURFACE_SURFACE_RULES_H_

#include <cstddef>

namespace sprout::refine {

/// The numbers of the rules for ToF points that are no parameters. By trial: the best of a few
/// values on scenes of half and third size; no table of them was kept.
struct SurfaceRules {
  /// Side of the windows of the paper's rules and of those that are compared, px (paper, II-B).
  static constexpr int kWindow = 5;
  static constexpr int kRadius = kWindow / 2;

  /// A cell reaches as far as the next return for this share of the returns: three of four. The
  /// others have lost their neighbour.
  static constexpr double kWithNext = 0.75;

  // Noise of the points.
  /// Quantile of the deviations that is read: low, since curved surfaces and edges deviate as well,
  /// but not nearly all points.
  static constexpr double kNoiseShare = 0.2;
  /// The same quantile of |x| for a normal distribution of σ = 1.
  static constexpr double kNoiseQuantile = 0.2533;
  /// Variance of a point less the mean of two others, for points of σ = 1: 1 + 2 / 4.
  static constexpr double kNoiseVariance = 1.5;
  static constexpr double kLeastSigmaPx = 0.05;  ///< of points that show no noise, px
  /// At most, px: below what a message may hold (1023), and no seed says anything from there on.
  static constexpr double kMostSigmaPx = 1000;

  // Loose points.
  /// Fewest of a cell's eight neighbours that must lie on its surface: along a line of equal depth,
  /// on a slant or a thin thing, there are two.
  static constexpr int kSupport = 2;
  /// Largest slant of a surface, px of disparity a px: over wide cells it puts neighbours further
  /// apart than the tolerance. By trial.
  static constexpr double kSteepest = 0.22;
  /// A loose point stays where the windows differ so many times less than at its neighbours'
  /// disparities. By trial.
  static constexpr double kMuchBetter = 2;

  // Hidden points.
  /// A piece hides a point outside its core where the windows differ so many times less at the
  /// piece's disparity than at the point's. By trial.
  static constexpr double kClearlyBetter = 1.25;
  /// Smallest side of the cells that points are looked up in, px. Of no influence but on time.
  static constexpr double kSmallestCellPx = 5;
  /// Pieces of such a cell that hide, the nearest: more than a sensor as fine as the images has.
  static constexpr size_t kMostPieces = 32;
};

}  // namespace sprout::refine

#endif  // SPROUT_SERVICES_REFINE_SURFACE_SURFACE_RULES_H_
