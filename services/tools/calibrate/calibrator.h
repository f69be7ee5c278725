#pragma once

#include <array>
#include <vector>

#include "common/core/result.h"
#include "common/rig/raw_rig.h"
#include "services/tools/calibrate/board.h"
#include "services/tools/calibrate/board_view.h"
#include "services/tools/calibrate/quality.h"

namespace sprout::calibrate {

/// A rig's calibration and its quality.
struct Calibration {
  RawRig rig;
  CalibrationQuality quality;
};

/// Calibrates a rig from views of a board:
///   1. each camera by itself, and the poses between them from the views that two of them see;
///   2. all of these together, from all corners;
///   3. the ToF camera's corners whose markers are too small to read, found where the result of 2
///   predicts them, and the ranges on the board's squares;
///   4. all of it together again.
/// Seconds for a hundred views; same input, same bytes.
///
/// @param sizes  of the images, px; ToF 0×0: there is none.
/// @returns an error, with what to do, when the views do not suffice for any calibration. The
///          quality says whether a calibration is poor.
Result<Calibration> Calibrate(const Board& board, const std::array<cv::Size, kCameraCount>& sizes,
                              std::vector<BoardView> views);

/// Checks a calibration that was found, here or by another program: CheckRawRig(), with what an
/// error may come from.
Result<void> CheckFoundRig(const RawRig& rig);

}  // namespace sprout::calibrate
