#pragma once

#include <cstdint>
#include <functional>
#include <opencv2/core.hpp>
#include <optional>
#include <stop_token>
#include <string>

#include "common/core/rig.h"
#include "common/core/tof_image.h"
#include "common/core/tof_zones.h"

namespace sprout::scenes {

/// A calibration that frames are rectified with, and its name.
struct NamedRig {
  Rig rig;
  std::string rig_id;
};

/// One synchronised triplet: rectified from a FrameSource, raw from a RawSource.
struct CapturedFrame {
  cv::Mat left;                            ///< 8UC1 or 8UC3 (BGR)
  cv::Mat right;                           ///< 8UC1 or 8UC3 (BGR), of the same size
  TofImage tof;                            ///< 0×0 without a ToF camera, or when it gave nothing
  std::optional<TofZones> tof_zones = {};  ///< nothing without a multi-zone sensor
  /// Middle of the exposure, µs since 1970-01-01 UTC; nothing when the source has no clock.
  std::optional<int64_t> utime = {};
  int64_t lost = 0;  ///< incomplete captures since the previous frame
  /// The newest trouble since the previous frame, one line.
  std::string trouble = {};
  /// Time between the earliest and the latest exposure of its images, ms; 0 when unknown.
  double spread_ms = 0;
  /// When this frame and those after it have another calibration than those before: only capture
  /// changes it.
  std::optional<NamedRig> new_rig = {};
};

/// Incomplete captures after the last frame.
struct LostFrames {
  int64_t count = 0;
  std::string trouble = {};  ///< reason of the newest
  /// At the end: whether there is a range sensor of which no image ever joined a pair, or of a
  /// recording most images of left and right became no frame, or its last ones fit no calibration.
  bool lacks_most = false;
};

/// Called by Next() at least ten times a second while it waits for cameras, to show that it is not
/// stuck; with the reason, for people, when there is a new one. May be empty.
using Waiting = std::function<void(const std::string& reason)>;

/// Where triplets come from: cameras, or what is used like them.
class TripletSource {
 public:
  virtual ~TripletSource() = default;

  /// Whether frames come when the cameras give them; otherwise when they are asked for.
  virtual bool is_live() const = 0;

  /// Whether frames that come when they are asked for have the times of a recording, which tell at
  /// what pace they once came.
  virtual bool is_recorded() const { return false; }

  /// Waits for the next frame. Nothing when there are no more, or a stop was requested. Waits for
  /// lost cameras.
  /// @throws ConfigError when a file of a dataset cannot be used.
  virtual std::optional<CapturedFrame> Next(const std::stop_token& stop) = 0;

  /// What was lost after the last frame, once Next() has returned nothing.
  virtual LostFrames lost_at_end() const { return {}; }
};

/// A source of rectified triplets.
class FrameSource : public TripletSource {
 public:
  /// Calibration of the first frame, and of all others until one with a new_rig.
  virtual const Rig& rig() const = 0;
};

}  // namespace sprout::scenes
