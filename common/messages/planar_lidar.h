#ifndef SPROUT_COMMON_MESSAGES_PLANAR_LIDAR_H_
#define SPROUT_COMMON_MESSAGES_PLANAR_LIDAR_H_

#include <cstdint>
#include <span>
#include <vector>

#include "common/core/frame_id.h"
#include "common/core/planar_scan.h"

namespace sprout {

/// The message of SPROUT_SCAN: a scan as bot_core.planar_lidar_t, which other programs read. It has
/// no header: of the frame only the time is kept.
std::vector<uint8_t> EncodeScan(const FrameId& id, const PlanarScan& scan);

/// Whether a message has the type of SPROUT_SCAN, by its fingerprint.
bool IsScan(std::span<const uint8_t> bytes);

/// Name of that type.
inline constexpr const char* kScanType = "bot_core.planar_lidar_t";

}  // namespace sprout

#endif  // SPROUT_COMMON_MESSAGES_PLANAR_LIDAR_H_
