#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "services/tools/calibrate/board.h"

namespace sprout::calibrate {

/// Corners of the board that were found in an image.
struct BoardCorners {
  std::vector<int> ids = {};             ///< as Board::corner() counts; ascending
  std::vector<cv::Point2d> pixels = {};  ///< position of each one, px
  int markers = 0;                       ///< markers read, of this board or another one

  int size() const { return static_cast<int>(ids.size()); }
};

/// Finds the corners of the board whose markers can be read, to some hundredths of a pixel.
/// @param image  8-bit grey. Nothing when there is no board. O(pixels).
BoardCorners FindBoard(const Board& board, const cv::Mat1b& image);

/// The same in an image of few pixels, such as the amplitudes of a ToF camera: a module has to be
/// 2 px wide or more.
/// @param amplitude  of any unit; empty: nothing is found.
BoardCorners FindBoardInAmplitude(const Board& board, const cv::Mat1f& amplitude);

/// Corners in an image of few pixels at expected places, also those whose markers are too small to
/// be read. Corners elsewhere, and places that do not look like a corner, are left out.
/// @param expected  where they should be, to a quarter of a square.
BoardCorners FindCornersNear(const Board& board, const BoardCorners& expected,
                             const cv::Mat1f& amplitude);

/// The corners of a board to a pixel or so; none when it is another board, of which the markers are
/// counted. A chessboard has to be seen as a whole; which of its corners is the first is said by
/// the colours of its squares or, where those look the same upside down (both numbers of squares
/// even, or both odd), by the upper edge of the image: one that stands on its side is left out.
BoardCorners ReadBoard(const Board& board, const cv::Mat1b& image);

/// What boards images show, whichever they are: "72 corners of a chessboard of 10x7 squares" or
/// "24 markers of DICT_5X5_250". Markers say more than corners; of several images the one with the
/// most counts; empty: none is seen. Takes up to some seconds an image.
std::string SeenBoards(const std::vector<cv::Mat1b>& images);

}  // namespace sprout::calibrate
