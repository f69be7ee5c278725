#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "common/rig/raw_rig.h"
#include "services/tools/calibrate/board.h"
#include "services/tools/calibrate/board_view.h"

namespace sprout::calibrate {

/// A rig as it could be bought: lenses with barrel distortion, cameras turned against each other, a
/// ToF camera like the SR4000 whose ranges are 1 % and 12 mm off.
RawRig SceneRig(cv::Size size);

/// The cameras of a rig looking at a board: each pixel through its true lens, the mean of several
/// rays; then noise. Same bytes at every call.
class BoardScene {
 public:
  BoardScene(const Board& board, const RawRig& rig);

  /// @param left_from_board  where the board stands.
  /// @param seed  of the noise.
  RigImages Render(const Pose& left_from_board, uint32_t seed) const;

  /// The corners that are found in such images, projected with noise, which takes less time.
  BoardView Project(const Pose& left_from_board, double noise_px, uint32_t seed) const;

 private:
  struct Camera {
    Lens lens;
    Eigen::Isometry3d left_from_camera;
    cv::Mat2d directions;  // (x, y, 1) of each pixel, with a border of one pixel
  };

  cv::Mat1f Brightness(const Camera& camera, const Eigen::Isometry3d& left_from_board,
                       int rays_per_side) const;
  TofImage RenderTof(const Eigen::Isometry3d& left_from_board, int rays_per_side,
                     uint32_t seed) const;

  Board board_;
  RawRig rig_;
  cv::Mat1b pattern_;  // kTexelsPerModule texels a module, with white paper around
  std::array<Camera, kCameraCount> cameras_;
};

/// Poses of a board as somebody holds it before the rig: all over the images, near and far,
/// tilted each way.
std::vector<Pose> BoardPoses(const Board& board, int count);

}  // namespace sprout::calibrate
