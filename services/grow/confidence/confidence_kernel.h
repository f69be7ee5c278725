#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "common/core/disparity_image.h"
#include "common/core/prior_map.h"
#include "services/grow/confidence/confidence_model.h"

// The features of the confidence, in whole numbers: the same bytes on every CPU. They are computed
// once for each cell of 2×2 pixels, at its upper left pixel; seeds for each block of 4×4.
namespace sprout::grow {

inline constexpr int kCellPx = 2;
inline constexpr int kBlockPx = 4;

inline cv::Size CellsOf(cv::Size pixels) {
  return {(pixels.width + kCellPx - 1) / kCellPx, (pixels.height + kCellPx - 1) / kCellPx};
}
inline cv::Size BlocksOf(cv::Size pixels) {
  return {(pixels.width + kBlockPx - 1) / kBlockPx, (pixels.height + kBlockPx - 1) / kBlockPx};
}

/// Images of the features of a frame (README, table of features), as bytes. Nearness is 255 minus
/// the distance in thirds of a cell or block, at least 0: chamfer distances with the mask 3, 4
/// (Borgefors, CVGIP 1986).
struct ConfidenceFeatures {
  cv::Mat1b step;      ///< cells: range of the disparities in 3×3 pixels, as LevelOf()
  cv::Mat1b bend;      ///< cells: second differences of the disparities, as LevelOf()
  cv::Mat1b margin;    ///< cells: 128 − Σ margin of the census costs
  cv::Mat1b gaps;      ///< cells: 10 times the number of gaps in 5×5 cells
  cv::Mat1b blank;     ///< cells: 10 times the number, in 5×5 cells, with L(u + 1) = L(u − 1)
  cv::Mat1b edge;      ///< cells: nearness of a step above 1 px
  cv::Mat1b tof_seed;  ///< blocks: nearness of a ToF seed
  cv::Mat1b seed;      ///< blocks: nearness of any seed
  cv::Mat1b rough;     ///< blocks: mean bend of the 13×13 blocks around
};

/// Writes rows of cells of step, bend, and edge: 255 for a step above 1 px, else 0. These images
/// have the size CellsOf().
void FindSteps(const DisparityImage& filled, const cv::Range& rows, ConfidenceFeatures& features);

/// Marks 255, all else 0, to nearness. O(pixels).
/// @param memory  two rows.
void SpreadNearness(cv::Mat1b& marks, std::vector<uint8_t>& memory);

/// Writes rows of cells of margin, gaps and blank, images of the size CellsOf().
/// @param left, right, grown  of the map's size; grown: before gap filling.
void MatchCells(const cv::Mat1b& left, const cv::Mat1b& right, const DisparityImage& grown,
                const DisparityImage& filled, const cv::Range& rows, ConfidenceFeatures& features);

/// Writes the two rows of pixels of each row of cells.
/// @param sigma_prior  counts, of the map's size; or empty: not known.
/// @param confidence, sigma  of the map's size.
void RateCells(const ConfidenceTables& tables, const ConfidenceFeatures& features,
               const DisparityImage& filled, const cv::Mat1b& sigma_prior, const cv::Range& rows,
               cv::Mat1b& confidence, cv::Mat1b& sigma);

}  // namespace sprout::grow
