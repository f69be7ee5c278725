#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "common/rig/rig.pb.h"
#include "common/scenes/frame_source.h"
#include "services/capture/genicam/camera.h"
#include "services/capture/genicam/device_clock.h"
#include "services/capture/triplet_synchronizer.h"

namespace sprout::capture {

/// "left camera (serial 123)", for messages.
std::string PlaceText(RigPlace place, const RigDescription& rig);

/// The device at a position of the rig; an empty one when the rig has none.
const CameraDevice& DeviceOf(RigPlace place, const RigDescription& rig);

/// Builds frames from the events of a rig's cameras: converts times to the host's, joins images to
/// triplets, and counts losses. Deterministic; reads no clock.
class FrameBuilder {
 public:
  explicit FrameBuilder(const RigDescription& rig);

  /// Takes an event of a camera.
  void Add(RigPlace place, CameraEvent event);

  /// The next frame, if it is final; call again, there may be more.
  /// @param now_utime  host's time, µs.
  std::optional<scenes::CapturedFrame> Next(int64_t now_utime);

  /// A message for people while no frame comes: the newest trouble, which is also reported with the
  /// next frame, or which images came but do not fit. Empty when there is nothing new.
  std::string NewTrouble();

 private:
  struct Place {
    DeviceClock clock;
    bool is_read = false;        // the clock by the device's answers, not by the arrival of images
    bool is_distrusted = false;  // its answers contradict its images
    int misfits = 0;             // consecutive images that contradict the clock
    int64_t images = 0;          // since the last frame
    int64_t lost = 0;            // images that came damaged or not at all; total
  };

  Place& At(RigPlace place) { return places_[static_cast<size_t>(place)]; }
  void AddImage(RigPlace place, DeviceImage image);
  void AddTime(RigPlace place, int64_t device_ns, int64_t utime);
  void CheckReading(RigPlace place, int64_t sent_ns, int64_t arrived_utime);
  // Reported with the next frame; a later trouble does not hide an earlier one.
  void Complain(RigPlace place, const std::string& text);
  int64_t LostOf(RigPlace place) const;
  int64_t LostSince(RigPlace place) const;
  int64_t Lost() const;

  RigDescription rig_;
  TripletSynchronizer synchronizer_;
  std::array<Place, kRigPlaces.size()> places_;
  bool has_frames_ = false;
  std::array<int64_t, 2> lost_before_{};  // left, right: at the last frame
  std::string trouble_;
  std::string told_;  // what NewTrouble() has given of it
};

}  // namespace sprout::capture
