#pragma once

#include <cstddef>

namespace sprout::refine {

/// The constants of stereo seeds. NOTES.md has what was measured. By trial: the best of a few
/// values on scenes of half and third size; no table of them was kept.
struct StereoRules {
  // Where seeds are taken.
  /// Columns of cells when stereo_spacing_px is 0: about as many as a ToF camera has columns across
  /// the left image (the SR4000 has 176).
  static constexpr int kColumns = 140;
  /// Images of so many pixels at most show whether disparities are negative. With a fourth of them
  /// one of their px is 16 of a 2 MP image, and Lampshade1's wall, at 5 px, seems to be there.
  static constexpr int kFewPixels = 128'000;
  /// FindCoarse() takes every so many rows and columns of such images as matches.
  static constexpr int kCoarseStep = 6;
  /// Smallest side of a cell, px of the images.
  static constexpr double kMinSpacingPx = 4;
  /// The largest disparity is this part of the image width beyond that of infinity when
  /// stereo_max_disparity_px is 0. With a focal length of f image widths that is z > 5 f baselines:
  /// indoors and on roads nothing is nearer.
  static constexpr int kWidthsPerDisparity = 5;
  /// From so many cells a point on, points are coarse: a cell beside one is not explained by it,
  /// and they show the shape of the scene as well as their noise.
  static constexpr double kCoarseCells = 1.5;
  /// Cells around a gap of at least 3×3 cells that want a seed, which are matched as well so that
  /// path costs settle. By trial.
  static constexpr int kSettleCells = 4;
  /// The same between coarse points, each of which holds the paths.
  static constexpr int kCoarseSettleCells = 2;
  /// The same around smaller gaps, which points on all sides hold. Measured (NOTES.md).
  static constexpr int kSmallGapCells = 1;
  /// Half the window that must lie in both images, px: growth's (5×5).
  static constexpr int kWindowRadius = 2;

  // What a seed is taken from: matched disparities around its pixel, px of the matched image.
  /// Half the window, px: that of the census, as far as a depth edge spoils matches.
  static constexpr int kReach = 2;
  /// Least difference at a depth edge, px. Measured: 3 is worse.
  static constexpr float kEdgePx = 2;
  /// Most that the mean of a pair differs from the seed's pixel on one surface, px. By trial.
  static constexpr double kSurfacePx = 1;
  /// Fewest of the 13 pairs that must be known. By trial.
  static constexpr int kMinPairs = 8;
  /// Windows overlap, so disparities share errors: one in so many is independent. By trial.
  static constexpr double kSharing = 4;
  /// Standard deviation of what all disparities around err alike, px of the matched image: their
  /// spread does not show it. By trial (NOTES.md).
  static constexpr double kSharedSigmaPx = 0.2;
  /// Stereo is asked where points leave more than this standard deviation, px of the matched image.
  /// A match is surer from kSharedSigmaPx on, but hardly so below. Measured (NOTES.md).
  static constexpr double kAskedSigmaPx = 0.3;

  // How sure an interpolation between ToF points is, eqs. (M1) and (M2).
  /// What may lie unseen between them, px of disparity a px of distance. What the truth of KITTI's
  /// frames does between points that far above and below (NOTES.md).
  static constexpr double kUnseenPerPx = 0.025;
  /// The same beyond the outermost points: the prior's slope_sigma.
  static constexpr double kBeyondPerPx = 0.05;
  /// Scale of the M-estimator for slopes: the prior's plane_scale_px, plane_scale_per_spacing, and
  /// how much wider its first round is.
  static constexpr double kPlaneScalePx = 0.4;
  static constexpr double kPlaneScalePerPx = 0.12;
  static constexpr double kFirstScale = 1.5;

  // The search from coarse to fine images.
  /// Disparities searched a pixel, except on the coarsest image: what a vector of 16 bytes holds.
  static constexpr int kLabels = 16;
  /// Most pixels of the coarsest image. By trial: fewer lose thin things, more take longer.
  static constexpr size_t kCoarsestPixels = 32'000;
  /// Most costs of the coarsest image, pixels times disparities: what 32,000 pixels have that are
  /// searched over 256. Wide and low images of few pixels have more, and are halved once more: some
  /// 20 bytes of memory a cost.
  static constexpr size_t kCoarsestCosts = kCoarsestPixels * 256;
  /// What a finer image may add to a coarser one's range, px. By trial.
  static constexpr int kBeyondPx = 2;
  /// Fewest pixels of a connected patch of disparities. By trial: smaller patches are mostly wrong.
  static constexpr int kMinPatch = 50;

  // The data term, eq. (M5), in census bits of the 5×5 window.
  static constexpr int kCensusRadius = 2;
  static constexpr int kBits = 24;
  /// Cost of a difference of half a grey level a px between the slopes of a pixel and its match,
  /// and the most of such costs. Measured (NOTES.md).
  static constexpr int kPerSlope = 2;
  static constexpr int kMaxSlope = 10;
  /// Cost of a match outside the right image: as bad as a random one, half of what is possible.
  static constexpr int kOutside = (kBits + kMaxSlope) / 2;
  /// Cost of each pixel of difference from a ToF seed's disparity. By trial, not sensitive.
  static constexpr int kKnownPerPx = 6;
  /// Most of that cost: no more than the data term can reach, so that the images can outvote a
  /// seed.
  static constexpr int kMaxKnown = kBits;
  static constexpr int kMaxCost = kBits + kMaxSlope + kMaxKnown;

  // The smoothness term, census bits: by trial (NOTES.md).
  /// P1, a change by 1 px; more where paths run along rows and columns only.
  static constexpr int SmallStep(bool diagonal) { return diagonal ? 5 : 6; }
  static constexpr int kLargeStep = 35;    ///< P2, a larger one, over equal grey values
  static constexpr int kMinLarge = 7;      ///< least P2, across an image edge; > P1
  static constexpr int kHalfLargeAt = 20;  ///< difference of grey values that halves P2

  // Which disparity is kept.
  /// By how many per cent the best disparity must cost less than all but its two neighbours. By
  /// trial.
  static constexpr int UniquePercent(bool diagonal) { return diagonal ? 15 : 20; }
  /// How far the right pixel's best match may lead from the left pixel, px: the rounding of both.
  static constexpr int kConfirmedPx = 1;

  // Bounds that follow, for numbers of 8 and 16 bits.
  /// Most that a path costs, less its minimum so far; eq. (M4).
  static constexpr int kMaxPath = kMaxCost + kLargeStep;
  static constexpr int kMaxPathSums = 8 * kMaxPath;
};

}  // namespace sprout::refine
