#pragma once

#include <algorithm>
#include <cstddef>

namespace sprout::refine {

/// The constants of the estimate of a range sensor's error. By trial on scenes of half and full
/// size unless a reason is given; NOTES.md has what was measured.
struct RangeRules {
  // The data term, eq. (R4).
  static constexpr int kWindowRadius = 3;  ///< half the window that is compared, px
  /// Offsets of a point's disparity that are tried: whole px from −7 to 8. As many as a vector of
  /// 16 bytes holds; multi-path makes ranges too long, so the true disparity is more often larger.
  static constexpr int kLabels = 16;
  static constexpr int kZeroLabel = 7;
  static constexpr double OffsetPx(int label) { return label - kZeroLabel; }
  /// Least variance of the noise of grey values, grey levels²: that of whole numbers.
  static constexpr double kMinNoise = 1.0 / 12;
  /// Equal neighbours, of all in a window, that show nothing; of noise of 0.5 grey levels it is
  /// 0.58.
  static constexpr double kBlankShare = 0.75;
  /// Images were JPEG if steps at the borders of blocks are that much larger than others, squared
  /// (quality 90: 2); by their difference their noise is larger.
  static constexpr double kBlockGain = 1.1;
  static constexpr double kBlockNoise = 3;
  /// Quantile of the nodes' noise that is that of the camera; fine texture adds to others.
  static constexpr double kNoiseQuantile = 0.1;
  /// A smaller likeness counts as this: the tail of an M-estimator.
  static constexpr float kMinLikeness = -0.2F;
  /// Steepest slope of a surface that is compared, px a px.
  static constexpr double kSteepest = 0.4;

  // The nodes.
  /// Most nodes: time is proportional to them.
  static constexpr size_t kMaxNodes = 4500;
  /// With fewer nodes nothing is estimated.
  static constexpr size_t kMinNodes = 20;
  /// Points of one surface: the plane of one is no farther from the other than this, px, and px a
  /// px of their distance, and these many standard deviations of their noise.
  static constexpr double kSurfacePx = 1.5;
  static constexpr double kSurfacePerPx = 0.05;
  static constexpr double kNoiseSigmas = 3;

  // The curve, eq. (R5).
  static constexpr int kCurveCandidates = 65;  ///< odd: the middle one is 0
  static constexpr size_t kNodesPerKnot = 60;
  static constexpr size_t kMaxKnots = 10;
  static constexpr float kMinDistinct = 0.05F;  ///< of a node that votes
  static constexpr float kMaxCost = 0.8F;       ///< of a vote of a node without noise
  static constexpr double kCurveMoved = 0.02;   ///< penalty of an error that is not 0
  static constexpr double kCurvePerPx = 0.002;  ///< penalty of a px of it
  static constexpr double kCurveStep = 0.03;    ///< penalty of a px of change at the nearest knot
  /// Knots that are farther apart, m of depth, may differ more: a wiggle of 10 mm with four periods
  /// in 7.5 m changes by 1.2 mm over this gap. The penalty falls in proportion, to this part of it:
  /// then the noise of a wall without texture moves its knot by some 15 mm at most.
  static constexpr double kNearKnotsM = 0.05;
  static constexpr double kLeastStep = 0.25;
  /// The same once a lidar is known to be off, and by how many standard deviations less than the
  /// bent curve the stiff one may gain. Right scans, and those turned by 0.2 degrees, lose nothing
  /// by it; with 0.5 a turned one of 19 does; a penalty three times as high, not four: ranges of
  /// +0.5 m 18.99, not 18.77 (NOTES.md).
  static constexpr double kStiffStep = 4 * kCurveStep;
  static constexpr double kBentSigmas = 0.4;
  /// Errors that are a part of the depth are tried in such steps, and taken unless a constant or
  /// the curve is better by so many standard deviations: of +0.2 and +1 m a constant is by 2.8 and
  /// more, of ranges that are 5 and 10 % long or short in two thirds of the frames by less, or it
  /// is worse.
  static constexpr double kFactorStep = 0.005;
  static constexpr double kMaxFactor = 0.3;  ///< more than kMaxDepthShare, to know what is beyond
  static constexpr double kOtherSigmas = 2.5;
  /// Two depths so far apart, m, may differ by about the whole error of a device: a sine of four
  /// periods in 7.5 m differs r.m.s. by its amplitude over 1.88 m / (1.41 π) = 0.42 m.
  static constexpr double kAlikeOverM = 0.4;
  /// The curve must gain as many standard deviations, by blocks of so many cells squared, within
  /// which mistakes go together. Right sensors stay below 3.0, scans of a few beams below 3.4 but
  /// for one frame of 19, since the slope between two beams is not known; one that is off by 10 mm
  /// has 4.0 and more even where there is hardly any texture.
  static constexpr int kBlockCells = 6;
  static constexpr double kSureSigmas = 3.5;
  /// A range sensor is off by centimetres, or a part in a hundred; where ranges are off by so great
  /// a part of the depth their unit, the focal length or the baseline is wrong.
  static constexpr double kMaxDepthShare = 0.2;
  /// Points that are far apart are believed without an error only if the images prefer their depths
  /// to ones that the data sheet allows, by so many standard deviations: right ones by 1.1 and more
  /// where an error would show, others by −0.2 at most but for one that wiggles (1.2).
  static constexpr double kRightSigmas = 1;
  /// Standard deviation of what all votes at a depth err alike, px, for people: 600 knots of twelve
  /// scenes are off by 0.98 standard deviations r.m.s., without it by 4.1. Growth needs no more
  /// than what differs from point to point.
  static constexpr double kCurveSharedPx = 0.25;

  // The field, eqs. (R6) and (R7).
  /// Fewer nodes of a camera whose points are far apart show no patches: a point every 80 px of
  /// 1.4 MP gives 100 to 150 nodes, every 40 px 310 to 760.
  static constexpr size_t kMinFieldNodes = 250;
  static constexpr float kFieldPerPx = 0.004F;
  static constexpr float kFieldSmallStep = 0.05F;  ///< P1
  static constexpr float kFieldLargeStep = 0.3F;   ///< P2
  static constexpr float kAcrossEdge = 0.3F;       ///< of both, between two surfaces
  /// Price of an offset that is not 0, before anything is known of the frame; then κ of (R7).
  static constexpr float kFieldMoved = 0.1F;
  static constexpr double kOddsPenalty = 0.03;
  static constexpr float kMinMoved = 0.01F;
  /// An offset is proved where so many nodes side by side cost so much less there.
  static constexpr float kProvedGain = 0.15F;
  static constexpr size_t kProvedNodes = 6;
  /// If fewer nodes than this share are proved, nothing is, but of a sensor whose edges show that
  /// it is wrong: right sensors have up to 0.039 (Books, whose truth itself is off in places),
  /// bumps of 1.5 px 0.057 and more.
  static constexpr double kMovedShare = 0.045;
  /// Where offsets reach so many px the images are compared again there, so many times at most: two
  /// times are worth 1.9 points with bumps of 6 px, the third 0.1. From 1 px on, what is nearer
  /// gets noisier (bumps of 1.5 px 96.65, not 96.84); 3 px: bumps of 6 px 93.59, not 93.75.
  static constexpr double kFarOffsetPx = 2;
  static constexpr int kMoreLooks = 3;
  // The membrane: rounds of Gauss and Seidel, the penalty of a difference between neighbours, and
  // of an offset. Both for a curvature of 1 a px².
  static constexpr int kRelaxations = 30;
  static constexpr double kStiffness = 0.05;
  static constexpr double kPull = 0.002;
  static constexpr double kMinVariance = 0.01;  ///< of the offsets, px²: below, there are none
  /// Offsets vary twice as much where no texture shows them as where it does: those that are not
  /// proved are taken for 0, and a frame's textured places may all be right.
  static constexpr double kUnseenFactor = 4;  ///< of the variance
  /// From this systematic error on, one standard deviation, stereo is asked at a point's place,
  /// too: a little more than what its matches share (kSharedSigmaPx of StereoRules); see NOTES.md.
  static constexpr double kUnsurePx = 0.25;
  /// With more noise even the mean over neighbours is less sure than stereo. Measured (NOTES.md).
  static constexpr double kMaxNoisePx = 1.5;
  /// The status tells the share of the points that were moved by more.
  static constexpr double kFarMovePx = kUnsurePx;
  /// Variance, px², of a node with a curvature of 1 a px²: measured with simulated bumps.
  static constexpr double kCurvatureVariance = 0.02;

  // Contradiction.
  /// Beside noise, what windows that belong together differ by, grey levels²: that of 2 grey
  /// levels.
  static constexpr double kUnlikeVariance = 4;
  /// A node can be judged with this signal to noise.
  static constexpr double kClearSignal = 3;
  /// It is contradicted when its likeness is below this share of what its noise allows.
  static constexpr double kContradicted = 0.5;
  /// If more nodes than this share are contradicted, no point is believed: right sensors have up to
  /// 0.19 (a scan of 16 beams), mirrored range images 0.27 and more.
  static constexpr double kRejectedShare = 0.22;
  /// But only if at MatchedShare() of these nodes stereo has a match that fits and is so many px
  /// off, within kMatchReach of the picture's width. Where half of the nodes are contradicted it is
  /// 0.48 and more with ranges that are mirrored, upside down or in a wrong unit, 0.28 and less
  /// beside images that are turned, striped, negative, of different focus or of different scenes.
  /// It is less where fewer nodes are contradicted, or nearly all, in dull scenes:
  /// wrong ranges 0.34 of 0.34, 0.24 of 0.99, such pairs 0.20 of 0.36, 0.13 of 0.9. From 1 px on
  /// rows that are off have more, from 2 px on a mirrored flat scene 0.01.
  static constexpr double kElsewherePx = 1.5;
  static double MatchedShare(double contradicted) {
    return std::min(0.85 * contradicted, 0.44 * (1 - contradicted / 2));
  }
  static constexpr double kMatchReach = 0.01;
  /// From this share on the rows do fit, whatever the nodes show: at 0.66 and more where they fit
  /// other rows by chance, as one in ten of KITTI's frames does with ranges twice or 1000 times too
  /// long; at 0.33 and less where rows are off.
  static constexpr double kMatchedOnOwnRows = 0.45;
  /// The same is asked of frames with fewer signs of a wrong sensor if nodes cost more than this in
  /// the mean: wrong sensors have up to 0.31, a blurred or covered camera 0.32 to 0.68.
  static constexpr double kPoorCost = 0.35;
  /// The pair is at fault if its nodes cost less by this part with rows of the right image so many
  /// px further down, in each of so many blocks across and down with the best ones. Right rows have
  /// up to 0.05, also with wrong sensors (0.117), rows that are half a px off up to 0.37, one px
  /// and more 0.31 and more, a turn by 0.3 degrees 0.14 to 0.48. A lidar's slopes are not known
  /// well enough (right scans have up to 0.2).
  static constexpr int kRowMoves[] = {0, -1, 1, -2, 2, -4, 4};  // the first one: as they are
  static constexpr double kRowsGain = 0.2;
  /// The right camera is turned, or has another focal length, if by this part more is gone with
  /// rows of each block's own than with those that all share. Right rows have up to 0.12 (0.16 of a
  /// lidar), rows that are off alike 0.08, a turn by 0.3 degrees and a scale of 1 % 0.2 to 0.5.
  static constexpr double kUnevenGain = 0.17;
  /// Then columns are off as far as rows, and the curve counts only if its median move is so many
  /// times as large. Right ranges have up to 0.85, ranges that are 2 % long 1.7 and more if that
  /// is over 3 px.
  static constexpr double kBeyondColumns = 1.2;
  static constexpr int kRowBlocks = 3;
  static constexpr size_t kMinFitNodes = 50;  ///< nodes
  static constexpr size_t kMaxFitNodes = 400;
  /// If more nodes than this share fit nowhere, the images show different things: 0.95 and more,
  /// rows that are off or a blurred camera up to 0.8. Then stereo gives no seeds either.
  static constexpr double kNothingFits = 0.9;

  // Rows of the right image that are shifted along themselves.
  /// What offsets differ by from their median; and what more than that counts as.
  static constexpr double kMinShiftPx = 0.25;
  static constexpr double kMaxResidualPx = 4;
  static constexpr size_t kShiftBands = 24;  ///< of rows, with as many places each
  /// One offset for each band leaves less than this part of what one for all leaves: of shifted
  /// rows 0.04 to 0.31, if they are by 3 px and more.
  static constexpr double kShiftLeft = 0.4;
  /// It is also less than this part of what others leave: one offset for each depth, or offsets
  /// that grow with the depth in each band. Of shifted rows 0.1 to 0.95 but in scenes with one
  /// depth a row; of 442 frames of wrong sensors, some off in their lower rows only, 0.99 and more.
  static constexpr double kShiftBetter = 0.95;

  // A displaced sensor.
  /// Asked where more nodes than this share are contradicted, or more points were moved far beside
  /// the curve, which moves all points at a depth alike. Right sensors have up to 0.07 and 0,
  /// displaced ones that do harm from 0.0297 on with few exceptions.
  static constexpr double kDoubtfulShare = 0.025;
  static constexpr double kDoubtfulMoves = 0.2;
  /// Asked, too, where the curve is farther from 0 than this part of the depth: data sheets allow a
  /// part in a hundred, and a slanted floor that lies some rows further down looks like such a
  /// curve.
  static constexpr double kDoubtfulOfDepth = 0.02;
  /// Asked, too, where more points than this share are nearer than stereo searches: a camera that
  /// wraps ranges gives 0.01 to 0.5 of them, in places where nodes show hardly anything.
  static constexpr double kNearShare = 0.025;
  /// Moves that are tried: up to this share of the picture's width, in so many steps to each side,
  /// by so many matches at most; then finer ones.
  static constexpr double kMaxDisplacement = 0.16;
  static constexpr int kMoveSteps = 12;
  static constexpr int kMoveRounds = 2;
  /// Fields of view that are tried, in parts of the calibrated one, and the first of finer steps.
  static constexpr double kSpreads[] = {0.7, 0.78, 0.86, 0.93, 1.07, 1.15, 1.25, 1.4};
  static constexpr double kSpreadStep = 0.04;
  /// Ranges that are tried are up to so many times as long or short, in steps of 1 %: 2 px at 200.
  static constexpr double kMaxScale = 1.43;
  static constexpr double kScaleStep = 0.01;
  /// Shear of a scan's rows that is tried, px across a px down: up to so many steps to either side.
  static constexpr double kShearStep = 0.02;
  static constexpr int kShearSteps = 15;
  static constexpr size_t kMaxMatches = 1000;
  /// Points and stereo agree to so many px.
  static constexpr double kAgreePx = 2;
  /// The points belong elsewhere if more of the matches agree there, by so many standard deviations
  /// over blocks of the picture, and by more than what agrees nowhere, which stereo has wrong; a
  /// share of kMoveGain is always enough. Sensors in their place gain up to 0.007 and 2.3 (182
  /// frames, wrong ranges among them); half a pixel of the sensor, which does no harm, 0.036.
  static constexpr int kMoveBlocks = 10;
  static constexpr size_t kMinCompared = 100;
  static constexpr double kMoveGain = 0.04;
  /// More than this share has to agree there: 0.90 and more do where a camera is displaced. The
  /// points of a lidar are too far apart to be compared: with right scans 0.54 to 0.71 agree, moved
  /// by a few rows up to 0.82.
  static constexpr double kMoveFits = 0.85;
  static constexpr double kMoveSigmas = 3;
  /// The same gain of a scan: of 145 right ones none gains 0.02 and 2 standard deviations; sheared,
  /// yawed and moved ones 0.016 to 0.2.
  static constexpr double kScanMoveGain = 0.02;
  /// Half of gain and standard deviations is enough for a second, finer look.
  static constexpr double kFirstLook = 0.5;

  // Points that stereo contradicts.
  /// Windows of a match differ so many times less than those of the points around it.
  static constexpr double kBetterMatch = 1.3;
  /// How far matches count, pixels of the range image, and the share of them, the nearest ones
  /// counting most, that has to be against a point.
  static constexpr int kVoteReach = 4;
  static constexpr double kAgainstShare = 1.0 / 3;
  /// If fewer matches than this share differ, none is: of right sensors up to 0.027 of the coarse
  /// ones do (Art, a point every 8 px).
  static constexpr double kDifferingShare = 0.03;
  /// A surface with fewer votes than this, and the share of them that agree, of what its points
  /// have elsewhere is not contradicted: right walls without texture have 0.05 to 0.15, all
  /// against, wrapped ones of Midd1 0.13 to 0.26; right ones with highlights 0.2 to 0.4, half
  /// against.
  static constexpr double kMinVotes = 0.1;
  static constexpr double kMinMixedVotes = 0.5;  ///< but no more than this
  /// The points claim too little error if the squares of their distances to matches are so many
  /// times what both claim: with bumps of 1.5 to 6 px, and of right sensors, up to 2.1 (Books, an
  /// SR4000 without its darkest half), with errors that change within a few points up to 11.
  static constexpr double kUnexplained = 2.5;
  /// A scan is not believed if more of its points than this share are contradicted, of so many at
  /// least. Of right scans up to 0.10 are (19 frames of KITTI, 16 to 64 beams; 13 scenes, 0.09), of
  /// every 3rd to 8th pixel of an SR4000 0.12 to 0.15 (Art), of mirrored, displaced or noisy ones
  /// 0.1 to 1.
  static constexpr double kWrongScan = 0.14;
  static constexpr double kMinScanPoints = 50;
  /// Asked where more nodes, and then coarse matches, than this share contradict it, or it has
  /// fewer points than these: in a quarter of KITTI's right frames, where it takes a tenth of the
  /// chain's time.
  static constexpr double kDoubtfulScan = 0.1;
  static constexpr size_t kFewScanPoints = 2500;
};

}  // namespace sprout::refine
