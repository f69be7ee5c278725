#ifndef SPROUT_SERVICES_TOOLS_CALIBRATE_BOARD_READER_H_
#define SPROUT_SERVICES_TOOLS_CALIBRATE_BOARD_READER_H_

#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "services/tools/calibrate/board.h"
#include "services/tools/calibrate/board_finder.h"

namespace sprout::calibrate {

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

#endif  // SPROUT_SERVICES_TOOLS_CALIBRATE_BOARD_READER_H_
