#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "common/core/frame_id.h"
#include "common/core/planar_scan.h"

namespace sprout {

/// The message of SPROUT_PREVIEW: a picture as bot_core.image_t, which other programs can show. It
/// has the frame's utime, but no header_t.
///
/// @param picture  8UC3 (BGR), not empty; sent as a JPEG stream.
/// @throws std::runtime_error when libjpeg refuses.
std::vector<uint8_t> EncodePreview(const FrameId& id, const cv::Mat& picture);

/// Whether a message has the type of SPROUT_PREVIEW, by its fingerprint.
bool IsPreview(std::span<const uint8_t> bytes);

/// Name of that type.
inline constexpr const char* kPreviewType = "bot_core.image_t";

/// The message of SPROUT_SCAN: a scan as bot_core.planar_lidar_t, which other programs read. It has
/// no header: of the frame only the time is kept.
std::vector<uint8_t> EncodeScan(const FrameId& id, const PlanarScan& scan);

/// Whether a message has the type of SPROUT_SCAN, by its fingerprint.
bool IsScan(std::span<const uint8_t> bytes);

/// Name of that type.
inline constexpr const char* kScanType = "bot_core.planar_lidar_t";

}  // namespace sprout
