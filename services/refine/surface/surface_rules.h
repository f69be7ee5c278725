#pragma once

#include <algorithm>
#include <cstddef>

namespace sprout::refine {

/// The constants of the rules for ToF points, beside the parameters. By trial: the best of a few
/// values on scenes of half and third size; no table of them was kept.
struct SurfaceRules {
  /// Side of the windows of the paper's rules and of those that are compared, px (paper, II-B).
  static constexpr int kWindow = 5;
  static constexpr int kRadius = kWindow / 2;

  /// The side of a cell is this quantile of the distances from a return to the next one: three of
  /// four. The others have lost their neighbour.
  static constexpr double kWithNext = 0.75;
  /// Points that are scattered, not in rows, are far from the next one in their own row: then cells
  /// that have any have more points than this, 30 to 180. Those of a lidar's beams have up to 6.
  static constexpr double kCrowd = 8;
  /// Cells are made as large as to have so many of scattered points: then three of four have a
  /// neighbour in the next cell.
  static constexpr double kScatteredPerCell = 1.4;

  // Noise of the points.
  /// Quantile of the deviations from which σ is estimated. It is low because points on curved
  /// surfaces and edges deviate as well, but they are few.
  static constexpr double kNoiseShare = 0.2;
  /// The same quantile of max(|x|, |y|) for normal distributions of σ = 1 with a correlation of
  /// 2/3: both have the point itself.
  static constexpr double kNoiseQuantile = 0.522;
  /// What neighbours along an axis differ by for the shape of the scene, px a px that they are
  /// farther apart than along the other axis: κ of (M1) of ../stereo.
  static constexpr double kShapePerPx = 0.025;
  /// Variance of a point less the mean of two others, for points of σ = 1: 1 + 2 / 4.
  static constexpr double kNoiseVariance = 1.5;
  /// How the noise depends on the disparity is seen in so many deviations at most, of so many
  /// groups of equally many; with fewer in one it is taken for the same everywhere.
  static constexpr size_t kNoiseSample = 3000;
  static constexpr size_t kNoiseBins = 6;
  static constexpr size_t kMinPerBin = 100;
  /// A higher power has to leave less than this part of the ratio of the groups' largest to their
  /// smallest noise. Simulated SR4000s, whose noise differs by what is dark, have ratios of up to
  /// 2.6, of which 0.6 and more are left; a sensor with the same noise in metres 14, of which 0.1.
  static constexpr double kEvener = 0.5;
  /// Side of a block whose noise is looked at, cells, and the fewest deviations of one. It counts
  /// from so many px and times the noise of the frame on: right sensors have as much in hardly more
  /// than the dark parts of Art (NOTES.md).
  static constexpr int kBlockCells = 8;
  static constexpr size_t kMinPerBlock = 25;
  static constexpr double kNoisyBlockPx = 3;
  static constexpr double kNoisyBlock = 3;
  /// How far beside a point they are matched, px.
  static constexpr int kMatchReachPx = 3;
  /// Most points that are looked at: enough for a median of a quarter of them, good to 10 %.
  static constexpr size_t kMatchedPoints = 1000;
  /// One in so many of the matches counts, the sharpest: others err more than the points.
  static constexpr size_t kSharpest = 4;
  static constexpr double kMedianOfNormal = 0.6745;  ///< of |x| for a normal distribution of σ = 1
  /// What such a match errs by itself, px: 0.49 px was measured with exact points (Dolls).
  static constexpr double kMatchSigmaPx = 0.5;
  static constexpr double kMinSigmaPx = 0.05;  ///< of points that show no noise, px
  /// Largest σ, px: below what a message may hold (1023); beyond it a seed carries no information.
  static constexpr double kMaxSigmaPx = 1000;

  // Depths in coarse steps.
  /// Depths of so many points are looked at. They come in steps if so many share each value; of
  /// fewer values each may be that of a surface.
  static constexpr size_t kStepSample = 4000;
  static constexpr size_t kPointsOfStep = 16;
  static constexpr size_t kMinSteps = 8;
  /// Finer steps do no harm, px: growth searches that far.
  static constexpr double kCoarseStepPx = 1.2;

  // Loose points.
  /// Fewest of a cell's eight neighbours that must lie on its surface: along a line of equal depth,
  /// on a slant or a thin thing, there are two.
  static constexpr int kSupport = 2;
  /// Largest slant of a surface, px of disparity a px: over wide cells a slant makes neighbours
  /// differ by more than the tolerance. By trial.
  static constexpr double kSteepest = 0.22;
  /// With fewer points, loose ones do not show that the sensor gives noise.
  static constexpr int kMinNoisePoints = 30;
  /// A loose point stays where the windows differ this many times less than at its neighbours'
  /// disparities. By trial.
  static constexpr double kMuchBetter = 2;

  // Smoothed range images.
  /// Least step between two surfaces, px, and how many of them make an edge.
  static constexpr double kEdgePx = 2;
  static constexpr double kEdgeSteps = 3;
  /// The same step where neighbours are so far apart, px.
  static constexpr double EdgePx(double spacing_px) {
    return std::max(kEdgePx, kSteepest * spacing_px);
  }
  /// What is wider is a slant, ToF pixels; of fewer edges nothing is told.
  static constexpr double kMaxEdgeWidth = 8;
  static constexpr size_t kMinEdges = 30;
  /// So many of the edges have to be wide: slants and round surfaces make wide ones of some. That
  /// quantile is 1.00 of exact ranges of 13 scenes, up to 1.38 of simulated SR4000s and of means
  /// over all of a pixel; 1.46 and more after a Gaussian of 0.7 pixels.
  static constexpr double kSharpestEdges = 0.25;
  static constexpr double kSmoothedWidth = 1.45;
  /// Along rows alone more than a pixel that sees two surfaces makes, 2: exact ranges, and means
  /// over all of a pixel, have up to 1.30; 2.37 and more after a Gaussian of 1.5 pixels along them.
  static constexpr double kMixedWidth = 2.1;
  /// By how much what lies beside a point of a smoothed image may be off its plane, px, and what
  /// the points that stay are believed to err alike, one standard deviation.
  static constexpr double kSmoothedPx = 1;
  static constexpr float kSmoothedSigmaPx = 0.4F;

  // Near surfaces that reach beyond their edges.
  /// Least step from one surface to the other, px, px a px of spacing, and standard deviations of
  /// the noise.
  static constexpr double kFattenedPx = 3;
  static constexpr double kFattenedSteepest = 0.33;
  static constexpr double kFattenedSigmas = 6;
  /// Edges are fattened if more than this share of so many near points beside them have windows
  /// that differ so many times less at the disparity beyond. Right and biased sensors have up to
  /// 0.30 (simulated SR4000s), those whose map is worse than none 0.36 and more.
  static constexpr size_t kEdgeSample = 350;
  static constexpr double kClearlyBetter = 1.3;
  static constexpr double kWrongEdges = 0.35;
  /// Edges do not reach so many ToF pixels and px too far: a stale or wrapped part of the image
  /// does.
  static constexpr int kMaxFattened = 4;
  static constexpr double kMaxFattenedPx = 32;

  // Hidden points.
  /// What a piece may lie off beside its point, px of disparity a px: its neighbours show its
  /// slant, not how the surface bends or ends. Measured (NOTES.md).
  static constexpr double kPiecePerPx = 0.2;
  /// A piece is at least as wide as the spacing of the points over this: along a beam of a lidar
  /// points are close, but its surface is no narrower for that.
  static constexpr double kPieces = 2;
  /// Slant that a piece may have where no neighbour shows it: that of a road under a car's cameras,
  /// baseline over height, 0.54 m / 1.65 m on KITTI.
  static constexpr float kUnseenSlope = 0.3F;
  /// Least width in the right image of what is 1 px wide in the left one: of what is steeper the
  /// right camera sees next to nothing.
  static constexpr double kMinSeen = 0.2;
  /// √2 − 1: 1 / (1 + that)² is a half.
  static constexpr double kHalfAtCore = 0.41421356;
  static constexpr double kMinCore = 0.01;  ///< spacings; of a smaller core the images decide all
  /// Difference of two windows of one surface: Σ(a − b)² / Σ(a² + b²) for noise of 1.4 grey levels
  /// at a mean of 100. Smaller differences say nothing.
  static constexpr double kNoise = 2e-4;
  /// Smallest side of the cells for looking up points, px. It affects time and, where points crowd,
  /// how many of them are kept.
  static constexpr double kMinCellPx = 0.5;
  /// Most pieces of such a cell that hide others, the nearest ones: more than a sensor as fine as
  /// the images has.
  static constexpr size_t kMaxPieces = 32;
};

}  // namespace sprout::refine
