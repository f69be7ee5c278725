#pragma once

#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "common/config/config.h"
#include "common/core/camera_motion.h"
#include "common/core/disparity_image.h"
#include "common/core/prior_map.h"
#include "common/core/result.h"
#include "common/core/rig.h"
#include "common/core/seed.h"
#include "common/core/tof_image.h"
#include "common/core/tof_zones.h"

namespace sprout {

class Chain;
namespace depth {
class MapFilter;
}

/// What the pipeline makes of one frame. All maps are of the left image's size.
struct DepthFrame {
  DisparityImage disparity;  ///< of the left image; see DisparityImage::Px() and ToPx()
  /// 255 · probability that the disparity is within 1 px of the true one, 0 where there is none;
  /// and the disparity's standard deviation in counts of 1/16 px (SigmaToPx()), kMaxSigmaCounts
  /// where there is none. Both empty unless grow.publish_confidence.
  cv::Mat1b confidence, sigma;
  /// The map for depths and points: `disparity`, or with depth { input: FUSED } `fused`, without
  /// the pixels that depth { min_m max_m region min_confidence remove_flying } leave out.
  DisparityImage kept;
  cv::Mat1f depth_m;  ///< of `kept`: z in the left camera's frame, m; NaN where there is none
  /// The map fused with those of earlier frames, its confidence as above, and how the left camera
  /// moved. Empty unless the pipeline has memory (temporal.in_pipeline).
  DisparityImage fused;
  cv::Mat1b fused_confidence;
  std::optional<CameraMotion> motion;
  PriorMap prior;      ///< D_p and its standard deviation; empty when growth does not use it
  SeedSet seeds;       ///< correspondences, and how many ToF points were dropped, and why
  SeedSet left_seeds;  ///< ToF points that only the left camera sees
  /// Why a stage had nothing to give ("refine: no ToF point has a return"), one line each; empty
  /// when all is well.
  std::vector<std::string> warnings;
  /// How far the range sensor is off, as the images show it, one line; empty: it is right, or they
  /// do not show it.
  std::string range_error;
  bool ranges_refused = false;  ///< no range point was believed; a warning says why
};

/// Which frame of a video a pipeline with memory gets.
struct FrameTime {
  int64_t utime = 0;  ///< capture time, µs; from any start
  int64_t seq = 0;    ///< number of the frame
  /// Pose of the left camera in a coordinate frame that does not move, only with temporal {
  /// in_pipeline: true motion: CHANNEL }. Nothing if it is not known; earlier frames are forgotten
  /// then.
  std::optional<Pose> pose = {};
};

/// Range image and rectified pair to depth: refine, prior and grow in one process, as the services
/// of these names compute it, to the byte. No messages, no clock, no files, no output.
///
///     sprout::Pipeline pipeline(sprout::LoadConfig({"default"}));
///     auto frame = pipeline.Compute(left, right, tof, rig);
///     if (frame) Use(frame->depth_m);
///
/// With temporal { in_pipeline: true } it has a memory, as sprout-temporal: `fused` and `motion`
/// (and depth_m, if it is of `fused`) depend on all frames since the newest reset, everything else
/// on the frame alone.
///
///     sprout::Pipeline pipeline(
///         sprout::LoadConfig({"default", "temporal { in_pipeline: true }"}));
///     auto frame = pipeline.Compute(left, right, tof, rig, {{.utime = utime, .seq = seq}});
///     if (frame) Use(frame->fused, frame->motion->start_from_left);
class Pipeline {
 public:
  /// @param config  see LoadConfig().
  /// @throws ConfigError naming the first value that is out of range, or that contradicts another:
  ///         temporal.in_pipeline and depth.min_confidence need grow.publish_confidence, depth {
  ///         input: FUSED } needs temporal.in_pipeline; and for depth.box, as the robot's frame is
  ///         not known here.
  explicit Pipeline(const SproutConfig& config);
  ~Pipeline();
  Pipeline(Pipeline&&) noexcept;
  Pipeline& operator=(Pipeline&&) noexcept;

  /// @param left, right  rectified pair of the calibrated size, 8UC1 or 8UC3 (BGR).
  /// @param tof          of the calibrated size; 0×0 when there is none: then all seeds come from
  ///                     stereo.
  /// @param rig          calibration; prepared again only when it changes.
  /// @param time         for the memory, which is lost where it goes back, or on by more than
  ///                     temporal.max_gap_s; the time of the last call again: from what was known
  ///                     before that. Nothing: the frame after the last one, without a gap.
  /// @param zones        of a multi-zone sensor, with refine { zones: true }; 0×0 when it gave
  ///                     nothing.
  /// @returns the depth of the left image, or an error that names what does not fit. A frame in
  /// which nothing is found is not an error: it has an empty map, and warnings. About 60 ns a pixel
  /// on one core with a ToF image, 150 without. On OpenCV's threads (cv::setNumThreads), with the
  /// same bytes for any number, and on any CPU. Keeps its memory from frame to frame, so one object
  /// serves one caller at a time; results stay the caller's.
  Result<DepthFrame> Compute(const cv::Mat& left, const cv::Mat& right, const TofImage& tof,
                             const Rig& rig, const std::optional<FrameTime>& time = {},
                             const TofZones& zones = {});

  /// Forgets all frames: the next one is the first. Without a memory it does nothing.
  void Reset();

 private:
  std::unique_ptr<Chain> chain_;
  std::unique_ptr<depth::MapFilter> filter_;
  bool depth_of_fused_;
  bool uses_zones_;
  bool uses_poses_;
  FrameTime last_;
};

}  // namespace sprout
