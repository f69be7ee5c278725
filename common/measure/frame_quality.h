#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "common/core/disparity_image.h"
#include "common/core/frame.h"

namespace sprout {

/// How good a frame looks, without ground truth. Figures that the frame's parts do not give are
/// empty. Shares are 0 to 1.
struct FrameQuality {
  std::optional<double> valid_share;   ///< pixels with a disparity
  std::optional<double> confidence;    ///< its mean over the pixels with a disparity, 1 = certain
  std::optional<double> misfit;        ///< see Misfit()
  std::optional<int64_t> seeds;        ///< of the ToF camera and of stereo
  std::optional<double> seeds_kept;    ///< ToF points that refinement kept; nothing without points
  std::optional<double> tof_coverage;  ///< see TofCoverage()

  /// What frames are ranked by, the lowest first:
  ///
  ///     score = valid_share · confidence · (1 − misfit)                                    (Q2)
  ///
  /// roughly the share of the left image with a trusted disparity that matches the images. An
  /// unknown factor counts as 1, so compare frames that have the same parts. Nothing without a
  /// disparity map.
  std::optional<double> score() const;
};

/// @param frame  any of left, right, disparity, confidence, seeds; parts of different sizes count
///               as missing.
/// @param misfit_one_in  samples the misfit: uses one of this many bands of 8 rows; 1 = all rows.
/// O(pixels); with all parts and all rows as long as about two conversions of the images to grey
/// and ten box filters.
FrameQuality QualityOf(const Frame& frame, int misfit_one_in = 1);

/// How badly the right image, warped to the left one by the disparities, matches it: the mean of
/// m(p) over the pixels p of a map that have a disparity and a match within the right image.
///
///     m(p) = ½ · (σ_L·σ_R − cov_LR) / (σ_L·σ_R + s²),    s = 2 grey levels               (Q1)
///
/// Standard deviations and covariance are those of the grey values of such pixels in the 5×5 window
/// around p. 0 = equal except for gain and offset, ½ = unrelated, 1 = inverted; s suppresses the
/// noise of windows without texture. Surfaces that only one camera sees, and windows across depth
/// edges, never match; in frames of one scene their number hardly changes.
/// @param left, right  rectified pair, grey, of the size of the map.
/// @returns nothing when no pixel has a match.
std::optional<double> Misfit(const cv::Mat1b& left, const cv::Mat1b& right,
                             const DisparityImage& disparity);

/// A figure of FrameQuality in tables, files and pages.
struct QualityColumn {
  std::string_view name;     ///< "valid_share": in headings, CSV and JSON
  std::string_view meaning;  ///< for people, one line
  bool more_is_better;
  int decimals;  ///< for people; files have all digits
  std::optional<double> (*value)(const FrameQuality&);
};

/// All figures, the score first.
std::span<const QualityColumn> QualityColumns();

/// The column with this name; nothing when there is none.
const QualityColumn* FindQualityColumn(std::string_view name);

/// A figure for people: with the column's decimals, "-" when it is not known.
std::string QualityText(const QualityColumn& column, const FrameQuality& quality);

/// The names of all figures as cells of CSV behind others: ",score,valid_share,...".
std::string QualityCsvHead();

/// The figures below QualityCsvHead(): with all digits, empty when not known.
std::string QualityCsvCells(const FrameQuality& quality);

/// How many of the figures are known.
size_t CountKnown(const FrameQuality& quality);

}  // namespace sprout
