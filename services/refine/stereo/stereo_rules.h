#ifndef SPROUT_SERVICES_REFINE_STEREO_STEREO_RULES_H_
#define SPROUT_SERVICES_REFINE_STEREO_STEREO_RULES_H_

#include <cstddef>
#include <cstdint>

namespace sprout::refine {

/// The numbers of stereo seeds. NOTES.md has what was measured. By trial: the best of a few values
/// on scenes of half and third size; no table of them was kept.
struct StereoRules {
  // Where seeds are taken.
  /// Columns of cells when stereo_spacing_px is 0: about as many as the pixels that a ToF camera
  /// (the SR4000 has 176) has across the left image.
  static constexpr int kColumns = 140;
  /// Cells hold some pixels of the matched image, px.
  static constexpr double kLeastSpacingPx = 4;
  /// The largest disparity is this part of the image width when stereo_max_disparity_px is 0. With
  /// a focal length of f widths that is z > 5 f baselines: indoors as on roads nothing is nearer.
  static constexpr int kWidthsPerDisparity = 5;
  /// Cells that are matched around those that want a seed, for paths to settle. By trial.
  static constexpr int kSettleCells = 4;
  /// Half the window that must lie in both images, px: growth's (5×5).
  static constexpr int kWindowRadius = 2;

  // What a seed is taken from: matched disparities around its pixel, px of the matched image.
  /// Half the window, px: that of the census, as far as a depth edge spoils matches.
  static constexpr int kReach = 2;
  /// A difference that is a depth edge, px. Measured: 3 is worse (NOTES.md).
  static constexpr float kEdgePx = 2;
  /// Largest difference of a pair's mean on one surface, px. By trial.
  static constexpr double kSurfacePx = 1;
  /// Fewest of the 13 pairs that must be known. Measured (NOTES.md, "How exact the seeds are").
  static constexpr int kFewestPairs = 8;
  /// Windows overlap, so disparities share their errors: of so many one is independent. By trial.
  static constexpr double kSharing = 4;
  /// Least standard deviation, px of the matched image: no match is more exact, whatever the
  /// spread.
  static constexpr double kLeastSigmaPx = 0.05;

  // From coarse to fine.
  /// Disparities a pixel, but on the coarsest image: what a vector of 16 bytes holds.
  static constexpr int kLabels = 16;
  /// Most pixels of the coarsest image. By trial: fewer lose thin things, more take longer.
  static constexpr size_t kCoarsestPixels = 32'000;
  /// What a finer image may add to a coarser one's range, px. By trial.
  static constexpr int kBeyondPx = 2;
  /// Fewest pixels of a patch of disparities. By trial: smaller ones are mostly wrong.
  static constexpr int kSmallestPatch = 50;

  // The data term, census bits of the 5×5 window.
  static constexpr int kCensusRadius = 2;
  static constexpr int kBits = 24;
  /// Of a match outside the right image: as bad as one by chance, half of the bits.
  static constexpr int kOutside = kBits / 2;
  /// What a pixel of difference from a ToF seed's disparity costs. By trial, not sensitive.
  static constexpr int kKnownPerPx = 6;
  /// At most: no more than the images can say, so that they can outvote it.
  static constexpr int kMostKnown = kBits;
  static constexpr int kMostCost = kBits + kMostKnown;

  // The smoothness term, census bits: by trial, none is sensitive.
  static constexpr int kSmallStep = 5;     ///< P1, a change by 1 px
  static constexpr int kLargeStep = 50;    ///< P2, a larger one, over equal grey values
  static constexpr int kLeastLarge = 7;    ///< P2 at least, over an edge of the image; > P1
  static constexpr int kHalfLargeAt = 20;  ///< difference of grey values that halves P2

  // Which disparity is kept.
  /// Per cent that the best one must cost less than any that is not beside it. By trial.
  static constexpr int kUniquePercent = 15;
  /// How far the right pixel's best match may lead beside, px: the rounding of either.
  static constexpr int kConfirmedPx = 1;

  // What follows for numbers of 8 and 16 bits.
  /// Most that a path costs, less its minimum so far; eq. (2).
  static constexpr int kMostPath = kMostCost + kLargeStep;
  static constexpr int kMostPathSums = 8 * kMostPath;
};

}  // namespace sprout::refine

#endif  // SPROUT_SERVICES_REFINE_STEREO_STEREO_RULES_H_
