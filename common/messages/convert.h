#pragma once

#include <lcmtypes/sprout/depth_counts_t.hpp>
#include <lcmtypes/sprout/depth_image_t.hpp>
#include <lcmtypes/sprout/disparity_image_t.hpp>
#include <lcmtypes/sprout/header_t.hpp>
#include <lcmtypes/sprout/image_t.hpp>
#include <lcmtypes/sprout/motion_t.hpp>
#include <lcmtypes/sprout/point_cloud_t.hpp>
#include <lcmtypes/sprout/prior_t.hpp>
#include <lcmtypes/sprout/process_info_t.hpp>
#include <lcmtypes/sprout/rig_change_t.hpp>
#include <lcmtypes/sprout/rig_t.hpp>
#include <lcmtypes/sprout/seeds_t.hpp>
#include <lcmtypes/sprout/stage_status_t.hpp>
#include <lcmtypes/sprout/tof_image_t.hpp>
#include <lcmtypes/sprout/tof_zones_t.hpp>
#include <opencv2/core.hpp>
#include <span>

#include "common/core/camera_motion.h"
#include "common/core/depth_counts.h"
#include "common/core/depth_image.h"
#include "common/core/disparity_image.h"
#include "common/core/frame_id.h"
#include "common/core/image.h"
#include "common/core/prior_map.h"
#include "common/core/process_info.h"
#include "common/core/result.h"
#include "common/core/rig.h"
#include "common/core/rig_change.h"
#include "common/core/seed.h"
#include "common/core/stage_status.h"
#include "common/core/tof_image.h"
#include "common/core/tof_zones.h"

// The only place where messages and domain values meet. ToMessage() cannot fail. FromMessage()
// checks everything; its error names field, value and what is allowed. Either copies the data once.
namespace sprout {

/// Encoding of a disparity map, and of the standard deviations of a prior.
enum class DisparityEncoding { kRawInt16, kDeltaZstd };

/// Largest message, bytes: LCM's own limit (LCM_MAX_MESSAGE_SIZE), so that messages from tcpq or
/// from a log have the same limit as with udpm.
inline constexpr size_t kMaxMessageBytes = 1 << 28;

/// Most pixels of a compressed picture or map, whatever the calibration says: some 60 kB can expand
/// to this many, and decoding takes up to 9 bytes of memory for each. Larger ones are sent raw.
inline constexpr int64_t kMaxCompressedPixels = 32'000'000;

/// Longest strings, bytes: of the names of a rig and of a stage, of configurations, and of all
/// others. Senders cut longer ones, so that a long error text does not make the whole status
/// invalid.
inline constexpr size_t kMaxNameLength = 64;
inline constexpr size_t kMaxConfigLength = 65536;
inline constexpr size_t kMaxTextLength = 1024;

header_t ToMessage(const FrameId& id);
Result<FrameId> FromMessage(const header_t& message);

/// @param image  8UC1 (sent as GREY) or 8UC3 in BGR order (sent as BGR3).
image_t ToMessage(const FrameId& id, const cv::Mat& image);
/// @param data    bytes that are not in the message, but behind it.
/// @param memory  as in DecodePart().
/// @returns 8UC1 or 8UC3 (BGR); RGB3 is reordered and MJPG decoded on the way.
Result<cv::Mat> FromMessage(const image_t& message, std::span<const uint8_t> data,
                            const cv::Mat1b& memory = {});

tof_image_t ToMessage(const FrameId& id, const TofImage& tof);
/// @returns an image with NaN wherever there is no return, see IsReturn().
Result<TofImage> FromMessage(const tof_image_t& message);

tof_zones_t ToMessage(const FrameId& id, const TofZones& zones);
/// Refuses what the type's comments do not allow; a target with STATUS_NONE loses its numbers.
Result<TofZones> FromMessage(const tof_zones_t& message);

rig_t ToMessage(const FrameId& id, const Rig& rig);
/// Refuses values that make projection impossible: non-finite numbers, focal lengths or a baseline
/// that are not positive, a quaternion that is not a rotation.
Result<Rig> FromMessage(const rig_t& message);

seeds_t ToMessage(const FrameId& id, const SeedSet& seeds);
Result<SeedSet> FromMessage(const seeds_t& message);

disparity_image_t ToMessage(const FrameId& id, const DisparityImage& disparity,
                            DisparityEncoding encoding);
Result<DisparityImage> FromMessage(const disparity_image_t& message, std::span<const uint8_t> data);

/// @pre sigma has the size of the disparities.
prior_t ToMessage(const FrameId& id, const PriorMap& prior, DisparityEncoding encoding);
Result<PriorMap> FromMessage(const prior_t& message);

depth_image_t ToMessage(const FrameId& id, const DepthImage& depth);
Result<DepthImage> FromMessage(const depth_image_t& message, std::span<const uint8_t> data);

point_cloud_t ToMessage(const FrameId& id, const PointCloud& cloud);
Result<PointCloud> FromMessage(const point_cloud_t& message);
/// Whether every point has z > 0, as all clouds in the frame of a camera; the error names the first
/// that has not.
Result<void> CheckInFront(const PointCloud& cloud);

motion_t ToMessage(const FrameId& id, const CameraMotion& motion);
Result<CameraMotion> FromMessage(const motion_t& message);

depth_counts_t ToMessage(const FrameId& id, const DepthCounts& counts);
Result<DepthCounts> FromMessage(const depth_counts_t& message);

stage_status_t ToMessage(const StageStatus& status);
Result<StageStatus> FromMessage(const stage_status_t& message);

process_info_t ToMessage(const ProcessInfo& info);
Result<ProcessInfo> FromMessage(const process_info_t& message);

rig_change_t ToMessage(const RigChange& change);
Result<RigChange> FromMessage(const rig_change_t& message);

}  // namespace sprout
