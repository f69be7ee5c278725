#pragma once

#include <Eigen/Geometry>
#include <array>
#include <vector>

#include "common/core/result.h"
#include "common/rig/raw_rig.h"
#include "services/tools/calibrate/board.h"
#include "services/tools/calibrate/board_view.h"

namespace sprout::calibrate {

/// The parameters of the corners' positions: a corner X of board view i is seen by camera c at
/// π_c(left_from_camera_c⁻¹ · left_from_board_i · X).
struct RigModel {
  std::array<Lens, kCameraCount> lenses;            ///< ToF 0×0: there is none
  std::array<Pose, kCameraCount> left_from_camera;  ///< the left one's is the identity
  std::vector<Pose> left_from_board;                ///< for each view
  double range_scale = 1;  ///< range along the ray = range_scale · measured + range_offset_m
  double range_offset_m = 0;
};

/// Fewest corners that a camera must see in a view for the view to count.
inline constexpr int kMinCorners = 6;

/// Fewest views in which a camera has to see the board.
inline constexpr int kMinViews = 5;

/// Whether all corners lie on one line of the board, which tells nothing about its pose.
/// @pre there is a corner.
bool IsOneLine(const Board& board, const BoardCorners& corners);

Eigen::Isometry3d ToTransform(const Pose& pose);
Pose ToPose(const Eigen::Isometry3d& transform);

/// Projection of a corner of the board into a camera, px.
Eigen::Vector2d PixelOfCorner(const RigModel& model, CameraIndex camera, size_t view,
                              const Eigen::Vector3d& corner);

/// A first model, good to some pixels: each camera calibrated by itself (OpenCV), the poses
/// between them from the views that both see.
/// @param sizes  of the images, px; ToF 0×0: there is none.
/// @returns an error that says which camera sees too little of the board.
Result<RigModel> InitialModel(const Board& board, const std::array<cv::Size, kCameraCount>& sizes,
                              const std::vector<BoardView>& views);

}  // namespace sprout::calibrate
