#ifndef SPROUT_COMMON_APP_BOARD_TEXT_H_
#define SPROUT_COMMON_APP_BOARD_TEXT_H_

#include <string>
#include <vector>

#include "common/app/status_board.h"

namespace sprout {

/// "good", "losing", "twice", "stale", "stopped", "missing".
std::string_view NameOf(Health health);

/// The board as lines for people: a heading, a row for each process, and the newest error of each
/// that has one.
/// @param colour  with ANSI colours for the health.
std::string BoardText(const std::vector<BoardRow>& rows, bool colour);

/// The board as one line of JSON: {"whole": bool, "stages": [{"stage": ..., "health": ..., and the
/// fields of stage_status_t that are numbers or texts}]}.
std::string BoardJson(const std::vector<BoardRow>& rows);

}  // namespace sprout

#endif  // SPROUT_COMMON_APP_BOARD_TEXT_H_
