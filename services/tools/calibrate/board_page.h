#ifndef SPROUT_SERVICES_TOOLS_CALIBRATE_BOARD_PAGE_H_
#define SPROUT_SERVICES_TOOLS_CALIBRATE_BOARD_PAGE_H_

#include <filesystem>
#include <string>

#include "services/tools/calibrate/board.h"

namespace sprout::calibrate {

/// The board as a page at true scale: the pattern, a line of a round length to check the print
/// with, and the flags of `sprout-calibrate` for this board. The same board gives the same
/// bytes.
///
/// @param path its suffix chooses the format; nothing is written
/// @return     a PDF or SVG file's content
/// @throws ConfigError for another suffix than .pdf or .svg
std::string BoardPage(const Board& board, const std::filesystem::path& path);

/// Width and height of the page, mm: the pattern with its margin, and the line below.
Eigen::Vector2d BoardPageSizeMm(const Board& board);

}  // namespace sprout::calibrate

#endif  // SPROUT_SERVICES_TOOLS_CALIBRATE_BOARD_PAGE_H_
