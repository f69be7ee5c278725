#pragma once

#include <opencv2/core.hpp>
#include <optional>

#include "common/config/config.h"
#include "common/core/camera_motion.h"
#include "common/core/disparity_image.h"
#include "common/core/frame_id.h"
#include "common/core/rig.h"
#include "services/temporal/confidence_scale.h"
#include "services/temporal/fusion_kernel.h"
#include "services/temporal/image_pyramid.h"
#include "services/temporal/photometric_doubt.h"

namespace sprout::temporal {

/// A frame of a video.
struct TemporalInput {
  FrameId id;
  cv::Mat1b left;            ///< grey; kept, so the caller must not change its pixels
  DisparityImage disparity;  ///< kept, too
  cv::Mat1b confidence;
  RectifiedPair pair;  ///< all of this size
  /// The left camera's pose in a fixed coordinate frame (start_from_left), used with motion:
  /// CHANNEL. Poses with an equal start_seq share that frame. Nothing if it is not known.
  std::optional<CameraMotion> odometry = {};
};

struct TemporalOutput {
  DisparityImage disparity;
  cv::Mat1b confidence;
  CameraMotion motion;
};

/// Fuses each disparity map with those before it, which it moves by the camera's own motion: a
/// Kalman filter at every pixel. Remembers the last frame and what was fused then; nothing older.
/// Neither threads nor instruction sets change a bit. One object serves one caller at a time. Keeps
/// about 20 bytes a pixel.
class TemporalFilter {
 public:
  /// @throws ConfigError for a value out of range.
  explicit TemporalFilter(const TemporalConfig& config);

  /// Where the motion is not known, the result is the input, and `motion.reset` says why. The frame
  /// of the last call may come again, with the same result; so may its image and map under other
  /// numbers, as a camera that hangs sends them: what was measured once is counted once. About 10
  /// ns a pixel.
  TemporalOutput Compute(const TemporalInput& input);

  /// Forgets all frames.
  void Reset();

  /// CameraMotion::resets of the last frame.
  int64_t resets() const { return now_.motion.resets; }

 private:
  struct State {
    bool known = false;
    FrameId id;
    cv::Mat1b left;
    cv::Mat1s measured;  // the frame's own map
    ImagePyramid pyramid;
    cv::Mat1f disparity;  // px, or kNone
    cv::Mat1f variance;   // px²
    CameraMotion motion;
    Pose left_from_last;
    std::optional<CameraMotion> odometry;
  };

  bool IsAsLast(const TemporalInput& input) const;
  MemoryReset ReasonToForget(const TemporalInput& input) const;
  void FindMotionOf(const TemporalInput& input);
  bool IsMotionUsable(const RectifiedPair& pair) const;
  void EstimateMotionOf(const TemporalInput& input);
  void TakeMotionOf(const TemporalInput& input);
  void Begin(const TemporalInput& input, TemporalOutput& output);
  void Fuse(const TemporalInput& input, TemporalOutput& output);

  TemporalConfig config_;
  ConfidenceScale scale_;
  PhotometricDoubt doubt_;
  State before_, now_;
  FrameId last_id_;                         // of the frame that came before the newest
  cv::Mat1f cells_, differences_, growth_;  // memory
};

}  // namespace sprout::temporal
