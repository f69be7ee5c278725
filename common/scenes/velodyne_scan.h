#pragma once

#include <Eigen/Geometry>
#include <filesystem>
#include <vector>

#include "common/core/rig.h"
#include "common/core/tof_image.h"

namespace sprout::scenes {

/// Points of a scan in the scanner's frame (x forward, y left, z up), m, as KITTI stores them:
/// float32 x, y, z and reflectance of each, little endian, nothing else.
/// @throws ConfigError naming the file: unreadable, empty, not whole points, a coordinate that is
/// not finite or beyond 1000 m, more points than such a scanner gives.
std::vector<Eigen::Vector3d> ReadVelodyneScan(const std::filesystem::path& file);

/// The points of every (64 / beams)th beam, the first kept being in the middle of that step. The
/// file has no beam numbers, so a point's follows from its elevation: 64 equal steps from +2° to
/// −24.9°; points above or below belong to the outermost beams. The real beams are closer together
/// in the upper half, and do not all start at one point, so sometimes pieces of two neighbouring
/// beams count as one.
/// @param beams  64, 32, 16, 8 or 4.
std::vector<Eigen::Vector3d> KeepBeams(const std::vector<Eigen::Vector3d>& points, int beams);

/// The scan as the range image of a ToF camera with the left camera's position and pixels:
/// TofGridCamera(pair, 1). A point belongs to the pixel whose centre is nearest to its projection,
/// and of several in a pixel the nearest one is kept. Depth is z in the left rectified frame. No
/// return elsewhere, no amplitude.
/// O(pixels + points).
TofImage TofImageFromScan(const std::vector<Eigen::Vector3d>& points,
                          const Eigen::Isometry3d& left_from_scanner, const RectifiedPair& pair);

}  // namespace sprout::scenes
