#pragma once

#include <filesystem>
#include <functional>
#include <opencv2/core.hpp>

#include "common/core/disparity_image.h"
#include "common/core/frame.h"
#include "common/core/rig.h"

namespace sprout {

/// The true disparity of a frame's left image.
struct FrameTruth {
  cv::Mat1f disparity_px;  ///< NaN or infinite = unknown; empty without ground truth
  cv::Mat1b non_occluded;  ///< see NonOccludedMask(); empty without ground truth
};

/// Whether a cloud can be made: it has disparity, left image and calibration, of one size.
bool HasCloud(const Frame& frame);

/// Writes a picture of every part of the frame that can be shown: left, right, tof, seeds_raw (the
/// ToF points before refinement), seeds, prior, prior_sigma, unfilled (as grown), disparity,
/// confidence, sigma (with a disparity map), cloud (from the side) as .png, and overview.png of
/// four of them. Pictures of depth share one colour scale.
/// @param truth    of its scene, of the size of its disparity, or empty: then there is no
///                 errors.png.
/// @param path_of  gives the path for "left.png" and others.
/// @throws std::runtime_error naming path and reason, and what path_of throws.
void WriteFramePictures(const Frame& frame, const FrameTruth& truth,
                        const std::function<std::filesystem::path(const char* what)>& path_of);

/// Left image, ToF depth, or the right image where there is none, disparity and the cloud from the
/// side, in one picture.
/// @pre HasCloud(frame), and it has a right image.
cv::Mat3b OverviewOf(const Frame& frame);

/// The coloured point cloud of a disparity map, seen by a camera moved to the right and up: shows
/// at a glance whether surfaces are flat and edges clean.
///
/// @param disparity  px, of the size of the pair.
/// @param left       8UC1 grey or 8UC3 BGR image of that size.
/// @returns a picture of the pair's size, nearly black where there is no point. O(pixels).
cv::Mat3b CloudView(const RectifiedPair& pair, const DisparityImage& disparity,
                    const cv::Mat& left);

}  // namespace sprout
