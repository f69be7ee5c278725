#pragma once

#include <array>
#include <opencv2/core.hpp>
#include <vector>

#include "common/core/tof_image.h"
#include "common/geometry/projection.h"
#include "common/inputs/feature_matches.h"
#include "common/inputs/pair_model.h"
#include "common/inputs/reading.h"
#include "common/inputs/repeated_range.h"

namespace sprout::inputs {

/// How a range image would have to be turned: mirrored about its diagonal, then about its vertical
/// and its horizontal middle.
struct Turn {
  bool transposed = false;
  bool mirrored = false;
  bool upside_down = false;

  bool operator==(const Turn&) const = default;
};
inline constexpr std::array<Turn, 8> kTurns = {
    {{},
     {.upside_down = true},
     {.mirrored = true},
     {.mirrored = true, .upside_down = true},
     {.transposed = true},
     {.transposed = true, .upside_down = true},
     {.transposed = true, .mirrored = true},
     {.transposed = true, .mirrored = true, .upside_down = true}}};

/// What a match says of the range points around it.
enum class Vote : int8_t {
  kNone,  ///< there are too few, or they lie on several surfaces
  kDisagrees,
  kAgrees,   ///< to 1 px, 3 % and 5 cm: what a device's own error comes to
  kIsClose,  ///< to 1 px and 1 %
};

/// What may have to be done to range points so that they agree with stereo.
struct Hypothesis {
  double factor = 1;  ///< of the ranges,
  Reading reading = Reading::kDepth;
  Turn turn = {};                ///< of the range image
  double ahead_m = 0;            ///< the points are moved ahead,
  cv::Point2d move_px = {0, 0};  ///< or in the picture,
  cv::Point2d spread = {1, 1};   ///< or their rays spread right and down, see RangeModel::spread
  double columns_px = 0;         ///< or the disparities of all matches are so much larger
};

/// How well range points and stereo agree under a hypothesis.
struct Agreement {
  Hypothesis with;
  int in_picture = 0;  ///< points
  int in_both = 0;     ///< of these, points that fall into the right image, too
  int compared = 0;
  int agreeing = 0;  ///< of them, closely or not
  int close = 0;
  std::vector<Vote> votes;      ///< one a match
  std::vector<double> logs;     ///< of those compared: ln(z_stereo / z_range)
  std::vector<double> offs_px;  ///< of those compared: disparity of the range − that of the match
  std::vector<double> offsets_m;  ///< of those that agree: z_range − z_stereo

  double share() const { return compared == 0 ? 0 : static_cast<double>(agreeing) / compared; }
  double close_share() const { return compared == 0 ? 0 : static_cast<double>(close) / compared; }
};

/// By how many standard deviations more matches agree (closely, if `least` says so) with `one` but
/// not with `other` than the other way round; matches that either does not compare do not count.
double MoreAgree(const Agreement& one, const Agreement& other, Vote least = Vote::kAgrees);

/// What range points and matches of the pair say of each other.
struct RangeModel {
  int pixels = 0;      ///< of the range sensor
  int values = 0;      ///< finite numbers > 0 among them
  int returns = 0;     ///< of these, see IsReturn()
  int pairs = 0;       ///< of returns side by side in a row
  int apart = 0;       ///< pairs that differ by more than a tenth
  int in_picture = 0;  ///< values that fall into the left image; estimated from a part of them
  int in_both = 0;     ///< values that fall into both images; estimated, too
  RepeatedRange repeated;
  Agreement as_is;
  Agreement scaled;   ///< of other factors the best, if as_is is not good
  Agreement misread;  ///< of other readings the best, if as_is is not good
  Agreement turned;   ///< of other turns the best; by 90° only if as_is is not good
  Agreement moved;    ///< of moves ahead the best, if as_is is not close
  Agreement shifted;  ///< the best move in the picture, if as_is is not close
  /// The best factor of the field of view's width and height (tangents), if as_is is not close:
  /// both alike, or such that pixels are square.
  Agreement spread;
  Agreement swapped;  ///< if as_is is not good: with the left image for the right one
  /// If as_is is not good: the best move of all columns, also of ranges that are turned or in
  /// another unit.
  Agreement aside;
  /// Over the matches that agree with `scaled`, or if it is empty with `as_is`: median of z_range /
  /// z_stereo, of z_range − z_stereo, m, and their standard deviations.
  Estimate ratio = {1, 0};
  Estimate offset_m;
};

/// @param matches    with disparities that fit the pair.
/// @param projector  of the frame's calibration; tof has its size.
/// O(ToF pixels), about 1 ns each, and 1 ms; 3 ms where they do not agree; one thread.
RangeModel CompareRanges(const std::vector<Match>& matches, const TofImage& tof,
                         const TofProjector& projector);

}  // namespace sprout::inputs
