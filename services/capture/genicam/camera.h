#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <stop_token>
#include <string>
#include <thread>

#include "services/capture/genicam/device.h"

namespace sprout::capture {

/// What happened at a camera.
struct CameraEvent {
  enum class Kind {
    kOpened,  ///< it sends; text: its name and format
    kImage,   ///< image: one came, complete or not
    kClock,   ///< clock: its clock was read
    kGone,    ///< it does not send; text: why. Repeated only for another reason
  };
  Kind kind = Kind::kImage;
  std::string text;
  DeviceImage image = {};
  ClockReading clock = {};
};

/// One camera of a rig, in its own thread. When it is lost, cannot be opened or is held by another
/// program, it is opened again without end: after 0.5 s at first, then each time after twice as
/// long, at most 8 s.
class Camera {
 public:
  /// @param tell  called from the camera's thread, also before the constructor returns.
  Camera(const DeviceSettings& settings, std::function<void(CameraEvent)> tell);

  Camera(const Camera&) = delete;
  Camera& operator=(const Camera&) = delete;
  /// Stops the camera.
  ~Camera() = default;

  /// Asks it to stop, and does not wait for it. Thread-safe.
  void RequestStop() { thread_.request_stop(); }

  /// Starts an exposure, if the camera is connected (RigDescription::SOFTWARE). Thread-safe.
  void Trigger();

  /// Starts an exposure at a time of its clock, if it is connected (RigDescription::PTP).
  /// Thread-safe.
  void TriggerAt(int64_t device_ns);

  /// Time of its clock; nothing when it is not connected or its clock cannot be read. Thread-safe.
  std::optional<ClockReading> ReadClock();

 private:
  void Run(const std::stop_token& stop);
  std::string Read(const std::stop_token& stop);
  void Ask();

  DeviceSettings settings_;
  std::function<void(CameraEvent)> tell_;
  std::mutex mutex_;  // guards device_ and commands to it
  std::unique_ptr<Device> device_;
  std::jthread thread_;  // last: it uses all others
};

}  // namespace sprout::capture
