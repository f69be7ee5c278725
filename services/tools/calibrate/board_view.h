#pragma once

#include <array>
#include <opencv2/core.hpp>

#include "common/core/tof_image.h"
#include "services/tools/calibrate/board.h"
#include "services/tools/calibrate/board_finder.h"

namespace sprout::calibrate {

/// The cameras of a rig, as an index.
enum CameraIndex : size_t { kLeft = 0, kRight = 1, kTof = 2 };
inline constexpr size_t kCameraCount = 3;
inline constexpr std::array<const char*, kCameraCount> kCameraNames = {"left", "right", "ToF"};

/// What the cameras see at one time, not rectified.
struct RigImages {
  cv::Mat left;   ///< 8UC1 or 8UC3 (BGR)
  cv::Mat right;  ///< 8UC1 or 8UC3 (BGR), of the same size
  TofImage tof;   ///< 0×0 without a ToF camera; its board is found in the amplitudes
};

/// The board as the cameras see it at one time.
struct BoardView {
  std::array<BoardCorners, kCameraCount> corners;
  TofImage tof;
};

}  // namespace sprout::calibrate
