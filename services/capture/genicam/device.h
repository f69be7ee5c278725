#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <set>
#include <string>

#include "common/core/result.h"
#include "common/core/rig.h"
#include "common/core/tof_image.h"
#include "common/rig/rig.pb.h"
#include "services/capture/genicam/device_setup.h"
#include "services/capture/genicam/discovery.h"
#include "services/capture/genicam/scan3d.h"

namespace sprout::capture {

/// An image of a device, or the report that there is none.
struct DeviceImage {
  int64_t device_ns = 0;      ///< start of the exposure by the device's clock
  int64_t exposure_ns = 0;    ///< how long it was exposed; 0 = unknown
  int64_t arrived_utime = 0;  ///< arrival of its first packet, host's clock, µs
  cv::Mat image;              ///< of a stereo camera; empty when it cannot be used
  TofImage tof;               ///< of a ToF camera; empty when it cannot be used
  int64_t lost = 0;           ///< images that did not come, and this one if it cannot be used
  std::string trouble;        ///< why the newest of them was lost
};

/// A reading of a device's clock, and the host's time.
struct ClockReading {
  int64_t device_ns = 0;
  int64_t utime = 0;  ///< arrival of the answer, µs
};

/// A camera that is open, set up and sending. Next() and is_lost() are for one thread, the others
/// for any thread, one call at a time.
class Device {
 public:
  /// Finds the camera, configures it and starts it. The error is one line that names what failed
  /// and what the camera allows.
  static Result<std::unique_ptr<Device>> Open(const DeviceSettings& settings);

  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;
  ~Device();

  /// Its name and format: "Lucid HLT003S 213700123 at 192.168.0.7: 640x480 Coord3D_C16".
  const std::string& text() const { return text_; }

  /// The next image; nothing when none came in time.
  std::optional<DeviceImage> Next(int64_t timeout_us);

  /// Whether it stopped answering. Aravis' heartbeat detects this within some 7 s.
  bool is_lost() const { return is_lost_; }

  /// Marks the camera as lost, so that closing it does not wait for it.
  void GiveUp() { is_lost_ = true; }

  /// Starts an exposure, for RigDescription::SOFTWARE.
  void Trigger();

  /// Starts an exposure at a time of its clock, ns, for RigDescription::PTP.
  void TriggerAt(int64_t device_ns);

  /// Reads its clock; nothing when it cannot be read. Takes some network round trips.
  std::optional<ClockReading> ReadClock();

  /// Reads the exposure time again: a camera with automatic exposure changes it.
  void ReadExposure();

 private:
  Device(OpenedCamera opened, const DeviceSettings& settings);

  Result<void> SetUp();
  Result<void> Start();
  DeviceImage Converted(ArvBuffer* buffer);
  Result<void> Fill(ArvBuffer* buffer, DeviceImage& image);
  int64_t CountMissing(uint64_t id);

  DeviceSettings settings_;
  FoundCamera found_;
  std::string text_;
  std::atomic<bool> is_lost_ = false;
  ArvObject<ArvCamera> camera_;
  ArvObject<ArvStream> stream_;
  unsigned long lost_handler_ = 0;
  Scan3d scan3d_;
  cv::Mat1d range_per_depth_;  // empty unless the device gives ranges along the ray
  std::optional<ClockReader> clock_reader_;
  int64_t exposure_ns_ = 0;
  std::string buffer_hint_;  // warning about a receive buffer that is too small
  uint16_t action_id_ = 0;
  uint64_t newest_id_ = 0;
  std::set<uint64_t> missing_ids_;
};

}  // namespace sprout::capture
