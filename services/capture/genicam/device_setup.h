#pragma once

#include <cstdint>
#include <optional>

#include "common/core/result.h"
#include "common/core/rig.h"
#include "common/rig/rig.pb.h"
#include "services/capture/genicam/arv_object.h"
#include "services/capture/genicam/scan3d.h"

namespace sprout::capture {

/// Settings of a camera of a rig.
struct DeviceSettings {
  CameraDevice device;  ///< rig.proto
  RigDescription::Trigger trigger = RigDescription::SOFTWARE;
  double frame_rate_hz = 10;
  bool is_tof = false;
  /// Lens of a ToF camera that gives ranges along the ray; nothing: read from the device.
  std::optional<Lens> lens;
};

/// Applies the rig file's settings to a camera: parts of the payload, pixel format, exposure,
/// gain, packet size, trigger, frame rate. The error names the rig file's field, the value and what
/// the camera allows.
Result<void> SetUpCamera(ArvCamera* camera, const DeviceSettings& settings);

/// Reads a camera's clock.
class ClockReader {
 public:
  /// Chooses the method: TimestampLatch (SFNC), GevTimestampControlLatch (older cameras), or none.
  explicit ClockReader(ArvCamera* camera);

  /// The device's time now, ns; nothing when it cannot be read.
  std::optional<int64_t> Read(ArvCamera* camera) const;

 private:
  const char* latch_ = nullptr;
  const char* value_ = nullptr;
  double tick_ns_ = 1;
};

/// How a ToF camera scales its numbers; missing values have Scan3d's defaults.
Scan3d ReadScan3d(ArvCamera* camera);

/// The lens that a ToF camera reports (Scan3dFocalLength, Scan3dPrincipalPointU and V), without
/// distortion; nothing when it reports none.
std::optional<Lens> ReadLens(ArvCamera* camera);

}  // namespace sprout::capture
