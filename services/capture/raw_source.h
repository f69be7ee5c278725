#ifndef SPROUT_SERVICES_CAPTURE_RAW_SOURCE_H_
#define SPROUT_SERVICES_CAPTURE_RAW_SOURCE_H_

#include <memory>
#include <optional>
#include <stop_token>
#include <string>

#include "common/core/result.h"
#include "common/rig/rectifier.h"
#include "services/capture/frame_source.h"

namespace sprout {

/// Cameras: triplets as they see them, neither rectified nor with corrected ranges.
class RawSource {
 public:
  virtual ~RawSource() = default;

  /// As FrameSource::Next().
  virtual std::optional<CapturedFrame> Next(const std::stop_token& stop) = 0;
};

/// Rectifies the images of a frame and corrects its ranges. The error names an image that is not of
/// the calibrated size. A ToF image of 0×0 stays one.
Result<CapturedFrame> RectifyFrame(const Rectifier& rectifier, CapturedFrame raw);

/// Frames of cameras, rectified; one that is not of the calibrated size counts as lost.
std::unique_ptr<FrameSource> Rectified(std::unique_ptr<RawSource> cameras, Rectifier rectifier);

/// Cameras and the calibration that belongs to them.
struct OpenedCameras {
  std::unique_ptr<RawSource> cameras;
  std::optional<RawRig> calibration;  ///< nothing when the rig is not calibrated yet
};

/// Opens what `source` names, when it names cameras; otherwise nothing.
///   opencv:LEFT,RIGHT  two videos, image lists (left_%04d.png) or devices that OpenCV opens
///   opencv:BOTH        one that has both views side by side, as UVC stereo cameras deliver them
/// ?rig=FILE behind it names the rig file with the calibration.
/// @throws ConfigError naming what is missing or wrong, and where.
std::optional<OpenedCameras> OpenCameras(const std::string& source);

}  // namespace sprout

#endif  // SPROUT_SERVICES_CAPTURE_RAW_SOURCE_H_
