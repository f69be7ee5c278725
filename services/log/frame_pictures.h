#ifndef SPROUT_SERVICES_LOG_FRAME_PICTURES_H_
#define SPROUT_SERVICES_LOG_FRAME_PICTURES_H_

#include <cstdint>
#include <span>
#include <string>

#include "common/core/frame.h"
#include "services/log/frame_truth.h"
#include "services/log/log_frames.h"

namespace sprout::log {

/// Whether there is a cloud to be made of it: disparity, left image and calibration, of one size.
bool HasCloud(const Frame& frame);

/// Writes a picture of every part that the frame has and that can be shown: left, right, tof,
/// seeds_raw (the ToF points before refinement), seeds, prior, prior_sigma, unfilled (as grown),
/// disparity, confidence, cloud (from the side) as .png, and overview.png of four of them. What has
/// a depth shares one scale of colours.
/// @param truth  of its scene, of the size of its disparity, or empty: then there is no errors.png.
/// @throws std::runtime_error naming path and reason; ConfigError when the folder cannot be made.
void WriteFramePictures(const Frame& frame, const FrameTruth& truth, FrameFileNames& names);

/// Writes what differs between two messages of one channel and frame: "000042_CHANNEL_a.png",
/// "_b.png" and "_difference.png". Only of disparity maps, priors and images of one size; of others
/// nothing.
/// @throws as WriteFramePictures().
void WriteDifferencePictures(std::span<const uint8_t> a, std::span<const uint8_t> b,
                             const std::string& channel, FrameFileNames& names);

}  // namespace sprout::log

#endif  // SPROUT_SERVICES_LOG_FRAME_PICTURES_H_
