#pragma once

#include <array>
#include <bitset>
#include <initializer_list>
#include <iterator>
#include <opencv2/core.hpp>
#include <optional>
#include <string_view>
#include <variant>

#include "common/core/camera_motion.h"
#include "common/core/depth_counts.h"
#include "common/core/depth_image.h"
#include "common/core/disparity_image.h"
#include "common/core/frame_id.h"
#include "common/core/prior_map.h"
#include "common/core/rig.h"
#include "common/core/seed.h"
#include "common/core/tof_image.h"
#include "common/core/tof_zones.h"

namespace sprout {

/// What a frame is made of; each part travels in a message of its own.
enum class Part {
  kLeft,             ///< left rectified image, grey or BGR
  kRight,            ///< right rectified image, grey or BGR
  kTof,              ///< ToF range image
  kRig,              ///< calibration; joined by rig_id, not by frame
  kSeeds,            ///< refined seeds
  kLeftSeeds,        ///< ToF points that only the left camera sees
  kPrior,            ///< prior disparity map D_p and its standard deviation
  kUnfilled,         ///< disparity map after growth, before gap filling
  kDisparity,        ///< final disparity map
  kConfidence,       ///< the probability that a disparity is within 1 px of the true one
  kSigma,            ///< standard deviation of the final disparities
  kDepth,            ///< depth of the left image, with its intrinsics
  kDepthSigma,       ///< standard deviation of that depth
  kCloud,            ///< its points
  kFused,            ///< disparity map fused with earlier frames
  kFusedConfidence,  ///< the same probability for it
  kMotion,           ///< how the left camera moved since the last frame
  kDepthCounts,      ///< what depth left out, by rule
  kBaseCloud,        ///< the points of the cloud in the robot's frame
  kTargetDepth,      ///< depth as another camera sees it
  kTargetCloud,      ///< its points, in that camera's frame
  kOdometry,         ///< motion by another program: only start_from_left and start_seq count
  kTofZones,         ///< distances of a multi-zone sensor
};
inline constexpr int kPartCount = static_cast<int>(Part::kTofZones) + 1;

/// A set of parts.
class PartSet {
 public:
  PartSet() = default;
  PartSet(std::initializer_list<Part> parts) {
    for (Part part : parts) Add(part);
  }
  void Add(Part part) { bits_.set(static_cast<size_t>(part)); }
  bool Has(Part part) const { return bits_.test(static_cast<size_t>(part)); }
  bool operator==(const PartSet&) const = default;

 private:
  std::bitset<kPartCount> bits_;
};

/// Content of a part: cv::Mat (8UC1 grey or 8UC3 BGR) for the images, 8UC1 for confidences and
/// sigma.
using PartValue = std::variant<cv::Mat, TofImage, Rig, SeedSet, DisparityImage, PriorMap,
                               DepthImage, PointCloud, CameraMotion, DepthCounts, TofZones>;

/// The parts of one capture, and of what was computed from it, that a stage asked for; the other
/// parts are empty.
struct Frame {
  FrameId id;
  cv::Mat left;   ///< 8UC1 or 8UC3 (BGR)
  cv::Mat right;  ///< 8UC1 or 8UC3 (BGR)
  std::optional<TofImage> tof;
  std::optional<Rig> rig;
  std::optional<SeedSet> seeds;
  std::optional<SeedSet> left_seeds;
  std::optional<PriorMap> prior;
  std::optional<DisparityImage> unfilled;
  std::optional<DisparityImage> disparity;
  cv::Mat confidence;  ///< 8UC1, 255 · probability; 0 where there is no disparity
  /// 8UC1, counts of 1/16 px (SigmaToPx()); kMaxSigmaCounts where there is no disparity.
  cv::Mat sigma;
  std::optional<DepthImage> depth;
  /// Standard deviation of depth, of its size; 0 = no depth, kMaxDepthSigmaCounts = that or more.
  std::optional<DepthImage> depth_sigma;
  std::optional<PointCloud> cloud;
  std::optional<DisparityImage> fused;
  cv::Mat fused_confidence;  ///< 8UC1, as confidence
  std::optional<CameraMotion> motion;
  std::optional<DepthCounts> depth_counts;
  std::optional<PointCloud> base_cloud;  ///< in the robot's frame
  std::optional<DepthImage> target_depth;
  std::optional<PointCloud> target_cloud;  ///< in the target camera's frame
  std::optional<CameraMotion> odometry;
  std::optional<TofZones> tof_zones;

  /// No parts: `left` and `right` in grey, where one has made them for several stages; else empty.
  cv::Mat1b left_grey, right_grey;
};

/// What stages look at that need no colours: the grey image if there is one, else the part.
inline const cv::Mat& GreyestLeft(const Frame& frame) {
  return frame.left_grey.empty() ? frame.left : frame.left_grey;
}
inline const cv::Mat& GreyestRight(const Frame& frame) {
  return frame.right_grey.empty() ? frame.right : frame.right_grey;
}

/// Pointer to the member of Frame that holds a part. Its type decides which message carries the
/// part, see TypeOf() in common/messages.
using PartMember =
    std::variant<cv::Mat Frame::*, std::optional<TofImage> Frame::*, std::optional<Rig> Frame::*,
                 std::optional<SeedSet> Frame::*, std::optional<DisparityImage> Frame::*,
                 std::optional<PriorMap> Frame::*, std::optional<DepthImage> Frame::*,
                 std::optional<PointCloud> Frame::*, std::optional<CameraMotion> Frame::*,
                 std::optional<DepthCounts> Frame::*, std::optional<TofZones> Frame::*>;

/// Properties of a part.
struct PartRow {
  Part part;
  std::string_view channel;  ///< without prefix
  PartMember member;
};

/// The table of all parts, in the order of their numbers. A new part is a number, a member of Frame
/// and a row here.
inline constexpr PartRow kPartTable[] = {
    {Part::kLeft, "SPROUT_LEFT", &Frame::left},
    {Part::kRight, "SPROUT_RIGHT", &Frame::right},
    {Part::kTof, "SPROUT_TOF", &Frame::tof},
    {Part::kRig, "SPROUT_RIG", &Frame::rig},
    {Part::kSeeds, "SPROUT_SEEDS", &Frame::seeds},
    {Part::kLeftSeeds, "SPROUT_LEFT_SEEDS", &Frame::left_seeds},
    {Part::kPrior, "SPROUT_PRIOR", &Frame::prior},
    {Part::kUnfilled, "SPROUT_UNFILLED", &Frame::unfilled},
    {Part::kDisparity, "SPROUT_DISPARITY", &Frame::disparity},
    {Part::kConfidence, "SPROUT_CONFIDENCE", &Frame::confidence},
    {Part::kSigma, "SPROUT_SIGMA", &Frame::sigma},
    {Part::kDepth, "SPROUT_DEPTH", &Frame::depth},
    {Part::kDepthSigma, "SPROUT_DEPTH_SIGMA", &Frame::depth_sigma},
    {Part::kCloud, "SPROUT_CLOUD", &Frame::cloud},
    {Part::kFused, "SPROUT_FUSED", &Frame::fused},
    {Part::kFusedConfidence, "SPROUT_FUSED_CONFIDENCE", &Frame::fused_confidence},
    {Part::kMotion, "SPROUT_MOTION", &Frame::motion},
    {Part::kDepthCounts, "SPROUT_DEPTH_COUNTS", &Frame::depth_counts},
    {Part::kBaseCloud, "SPROUT_BASE_CLOUD", &Frame::base_cloud},
    {Part::kTargetDepth, "SPROUT_TARGET_DEPTH", &Frame::target_depth},
    {Part::kTargetCloud, "SPROUT_TARGET_CLOUD", &Frame::target_cloud},
    {Part::kOdometry, "SPROUT_ODOMETRY", &Frame::odometry},
    {Part::kTofZones, "SPROUT_TOF_ZONES", &Frame::tof_zones},
};
static_assert(std::size(kPartTable) == kPartCount);

/// Row of a part.
constexpr const PartRow& RowOf(Part part) { return kPartTable[static_cast<size_t>(part)]; }

/// The channel of a part, without prefix.
constexpr std::string_view ChannelOf(Part part) { return RowOf(part).channel; }

/// Whether sprout-depth publishes it: of each N-th frame alone with `depth { every: N }`.
constexpr bool IsOfDepth(Part part) {
  switch (part) {
    case Part::kDepth:
    case Part::kDepthSigma:
    case Part::kCloud:
    case Part::kDepthCounts:
    case Part::kBaseCloud:
    case Part::kTargetDepth:
    case Part::kTargetCloud:
      return true;
    default:
      return false;
  }
}

/// The part that a channel carries: the inverse of ChannelOf().
/// @param prefix  of the graph. Channels without it belong to another graph.
/// @returns nothing for a channel that carries no part of a frame.
std::optional<Part> PartOf(std::string_view channel, std::string_view prefix = {});

/// All parts, in the order of their numbers.
inline constexpr std::array<Part, kPartCount> kAllParts = [] {
  std::array<Part, kPartCount> parts{};
  for (size_t i = 0; i < parts.size(); ++i) parts[i] = kPartTable[i].part;
  return parts;
}();

/// The set of all parts.
inline PartSet AllParts() {
  PartSet parts;
  for (const Part part : kAllParts) parts.Add(part);
  return parts;
}

/// Stores a part in the frame.
/// @pre the alternative in `value` is the one of `part`.
void SetPart(Frame& frame, Part part, PartValue value);

/// The part of a frame, as SetPart() takes it; images share their pixels.
/// @pre the frame has it.
PartValue GetPart(const Frame& frame, Part part);

/// Memory that the parts of a frame take, bytes. O(1).
size_t BytesOf(const Frame& frame);

/// Size of the rectified images of a frame, taken from its first image or map; nothing when it has
/// none yet.
std::optional<cv::Size> ImageSize(const Frame& frame);

}  // namespace sprout
