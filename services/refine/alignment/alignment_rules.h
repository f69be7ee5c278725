#pragma once

#include <cstddef>

namespace sprout::refine {

/// The constants of the alignment of the ToF camera. A cell is the size of a ToF pixel in the
/// images that are searched. NOTES.md has what was measured; what is neither there nor derived was
/// found by trial.
struct AlignmentRules {
  // The images.
  /// They are halved until a cell is at most this large, px: profiles are averaged over a cell, so
  /// more pixels only take time.
  static constexpr double kMaxCellPx = 6;
  static constexpr int kMinSide = 64;         ///< no image is halved below this, px
  static constexpr double kLimitCellPx = 16;  ///< larger cells count as this, px

  // Ends in the ToF image.
  static constexpr int kMaxMixed = 3;  ///< pixels that mix both surfaces: lens blur, filters
  static constexpr double kSameSurface = 0.25;  ///< most on one surface, share of the step
  static constexpr int kDiscRadius = 3;  ///< disc whose near part gives the normal, ToF pixels
  /// Cosine between the normal and the row or the column. Every direction is within 45° (0.71) of
  /// one of the two; the rest is the error of the normal.
  static constexpr double kMinAcross = 0.6;
  /// Least step of the disparity for the two surfaces to look different, px of these images;
  /// found by trial.
  static constexpr double kMinStepPx = 3;

  // Evidence of the images, eqs. (A3) and (A4).
  static constexpr int kTangentReach = 1;    ///< pixels to either side along the edge that count
  static constexpr float kMaxMisfit = 20;    ///< T: larger differences count as T, grey levels
  static constexpr float kMaxContrast = 40;  ///< larger steps count as this one, grey levels
  static constexpr float kContrastWeight = 0.5F;  ///< measured (NOTES.md): 0, 1 and 2 are worse

  // The offset, eq. (A5).
  static constexpr double kMaxCells = 2;         ///< largest offset that is searched, cells
  static constexpr size_t kMaxEdges = 1000;      ///< more take time and do not help
  static constexpr double kVotesPerCell = 3;     ///< along either side: profiles are a cell wide
  static constexpr double kStepCells = 0.3;      ///< of finite differences, cells
  static constexpr int kMaxSteps = 30;           ///< of Newton's method
  static constexpr double kConvergedPx = 0.002;  ///< ends the iteration: too small to matter

  // Standard deviations, eq. (A6).
  static constexpr double kBlockCells = 16;  ///< edges in one block may share their errors
  /// Standard deviation of what shifts all edges on one side of objects (round rims, shadows,
  /// blur), cells.
  static constexpr double kSideSigmaCells = 0.08;
  /// Plus this share of the shift outwards o that all edges have in common. Measured: with both a
  /// right pose is at most 3.1 standard deviations off, and one that is 3 px off at least 4.2.
  static constexpr double kSideSigmaOutwards = 1 / 3.0;

  // When it is sure.
  static constexpr int kMinEdges = 50;
  /// Least evidence, of at most 1.5, for an edge to count.
  static constexpr float kClearEdge = 0.1F;
  /// Most votes above the mean of the second-best offset, as share of the best one's.
  static constexpr double kMaxDoubt = 0.7;
  static constexpr double kElsewhereCells = 1.5;  ///< offsets this far apart are different
  static constexpr double kMaxSigmaCells = 0.25;
  /// Length of an offset, in standard deviations, above which the calibration is wrong: a right one
  /// has it by chance once in 270 000 frames, exp(−5² / 2). Right poses have up to 3.4, with wrong
  /// ranges 4.1, without dark returns 4.2; those that are 3 px off 4.2 and more, 11 of 13
  /// scenes 6.9 and more.
  static constexpr double kSignificant = 5;
  /// But not if the images differ more at the points once they are moved, by so many standard
  /// deviations: where a range image was moved by up to two of its pixels up to 0.7 (but for one
  /// frame of 144, 6.5), of wrong offsets 4.9 to 19.
  static constexpr double kWorseSigmas = 2;

  // The scan of a lidar, eqs. (A7) to (A10).
  static constexpr float kMaxExcess = 0.6F;      ///< a larger excess counts as this one
  static constexpr double kMovePenalty = 0.001;  ///< cost of a move, per px
  static constexpr double kMaxMovePx = 32;       ///< longest move that is searched
  static constexpr double kNearQuantile = 0.9;   ///< of the disparities: that of a near point
  static constexpr double kFirstStepPx = 4;      ///< across: half a window
  static constexpr int kMaxSweeps = 12;          ///< of the search along all axes; it ends before
  /// Points that the search looks at, and those that decide; fewer find fewer scans that are off.
  static constexpr size_t kFirstScanPoints = 1200;
  static constexpr size_t kMaxScanPoints = 2500;
  static constexpr size_t kMinScanPoints = 100;
  static constexpr int kBlockWindows = 3;  ///< side of a block within which mistakes go together
  /// A move is sure from so many standard deviations on: right scans of 4 to 64 beams have up to
  /// 3.4 (19 frames each; one, that an error of the ranges explains better, 3.8), those that are
  /// pitched by 0.2 degrees 4.5 and more with 16 beams.
  static constexpr double kMoveSigmas = 3.5;
  /// The lidar is rolled if that gains so many more than a turn alone: of 206 right scans of 4 to
  /// 64 beams one has 4.7, the others up to 3.1; those rolled by 1 degree 6.3 and more.
  static constexpr double kRollSigmas = 5;
  /// The rig has moved if that gains so many more than a turn alone: scans of 0.1 s before the pair
  /// have 2.6 to 5.9, others up to 2.0. Points farther away must gain more, since what the lidar
  /// sees past the edges of near surfaces fits there: turned and right scans have up to 4.6, those
  /// of 0.1 s after the pair 6.3 and more in 33 of 35 frames.
  static constexpr double kNearerSigmas = 2.5;
  static constexpr double kFartherSigmas = 5.5;
};

}  // namespace sprout::refine
