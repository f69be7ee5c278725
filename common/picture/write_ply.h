#pragma once

#include <filesystem>
#include <opencv2/core.hpp>

#include "common/core/disparity_image.h"
#include "common/core/result.h"
#include "common/core/rig.h"

namespace sprout {

// Both write binary little-endian PLY, the whole file or none (see OutputFile); errors name path
// and reason, among them sizes that differ. Coordinates are metres in the left rectified frame
// (x right, y down, z forward), each vertex has the colour of its pixel in the left image (8UC1
// grey or 8UC3 BGR), and with `confidence` (8UC1 of the map's size) the property `confidence`: 255
// times the probability of an error of at most 1 px. Pixels without a disparity, and those whose
// disparity gives no positive depth, are left out. O(pixels).

/// Writes the point cloud of a disparity map: vertices, row by row.
[[nodiscard]] Result<void> WriteCloudPly(const std::filesystem::path& path,
                                         const RectifiedPair& pair, const DisparityImage& disparity,
                                         const cv::Mat& left, const cv::Mat& confidence = {});

/// Disparities (px) of one mesh triangle differ by at most this. Growth steps by at most 1 px from
/// a pixel to its neighbour and a triangle joins three pixels by two such steps, so a surface that
/// grew as one stays whole, even if it is slanted and its disparities are whole numbers; a larger
/// jump is a depth edge.
inline constexpr double kMaxMeshJumpPx = 2;

/// Writes the cloud as a surface: the vertices of WriteCloudPly() and up to two triangles in each
/// cell of 2 × 2 pixels. A cell is split along the diagonal with the smaller jump, which follows
/// depth edges, and triangles that miss a vertex or jump by more than kMaxMeshJumpPx are cut out.
/// Triangles are counter-clockwise as the camera sees them: normals point towards it.
[[nodiscard]] Result<void> WriteMeshPly(const std::filesystem::path& path,
                                        const RectifiedPair& pair, const DisparityImage& disparity,
                                        const cv::Mat& left, const cv::Mat& confidence = {});

}  // namespace sprout
