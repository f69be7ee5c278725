#ifndef SPROUT_SERVICES_CAPTURE_GENICAM_DEVICE_SETUP_H_
#define SPROUT_SERVICES_CAPTURE_GENICAM_DEVICE_SETUP_H_

#include <cstdint>
#include <optional>

#include "common/core/result.h"
#include "common/core/rig.h"
#include "common/rig/rig.pb.h"
#include "services/capture/genicam/arv_object.h"
#include "services/capture/genicam/scan3d.h"

namespace sprout::capture {

/// How a camera of a rig is driven.
struct DeviceSettings {
  CameraDevice device;  ///< rig.proto
  RigDescription::Trigger trigger = RigDescription::SOFTWARE;
  double frame_rate_hz = 10;
  bool is_tof = false;
  /// Of a ToF camera that gives ranges along the ray; nothing: the device's own idea of its lens.
  std::optional<Lens> lens;
};

/// Writes what the rig file asks for into a camera: parts of the payload, pixel format, exposure,
/// gain, packet size, trigger, frame rate. The error names the rig file's field, the value and what
/// the camera allows.
Result<void> SetUpCamera(ArvCamera* camera, const DeviceSettings& settings);

/// Reads a camera's clock.
class ClockReader {
 public:
  /// Finds out how: TimestampLatch (SFNC), GevTimestampControlLatch (older cameras), or not at all.
  explicit ClockReader(ArvCamera* camera);

  /// Its time now, ns; nothing when it does not tell.
  std::optional<int64_t> Read(ArvCamera* camera) const;

 private:
  const char* latch_ = nullptr;
  const char* value_ = nullptr;
  double tick_ns_ = 1;
};

/// What a ToF camera says about its numbers; what it does not say is as Scan3d has it.
Scan3d ReadScan3d(ArvCamera* camera);

/// A ToF camera's own idea of its lens (Scan3dFocalLength, Scan3dPrincipalPointU and V), without
/// distortion; nothing when it does not say.
std::optional<Lens> ReadLens(ArvCamera* camera);

}  // namespace sprout::capture

#endif  // SPROUT_SERVICES_CAPTURE_GENICAM_DEVICE_SETUP_H_
