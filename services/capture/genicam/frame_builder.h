#ifndef SPROUT_SERVICES_CAPTURE_GENICAM_FRAME_BUILDER_H_
#define SPROUT_SERVICES_CAPTURE_GENICAM_FRAME_BUILDER_H_

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "common/rig/rig.pb.h"
#include "services/capture/genicam/camera.h"
#include "services/capture/genicam/device_clock.h"
#include "services/capture/genicam/triplet_synchronizer.h"
#include "services/datasets/frame_source.h"

namespace sprout::capture {

/// "left camera (serial 123)", for messages.
std::string PlaceText(RigPlace place, const RigDescription& rig);

/// The device of a place; an empty one when the rig has none.
const CameraDevice& DeviceOf(RigPlace place, const RigDescription& rig);

/// Frames from what happens at a rig's cameras: times become the host's, images triplets, and what
/// is lost is counted. Deterministic, no clock inside.
class FrameBuilder {
 public:
  explicit FrameBuilder(const RigDescription& rig);

  /// Takes in what happened at a camera.
  void Add(RigPlace place, CameraEvent event);

  /// The next frame, if it is settled; call again, there may be more.
  /// @param now_utime  host's time, µs.
  std::optional<datasets::CapturedFrame> Next(int64_t now_utime);

  /// What to tell people while no frame comes: the newest trouble, which goes with the next frame,
  /// too, or which images came and do not fit. Empty when there is nothing new.
  std::string NewTrouble();

 private:
  struct Place {
    DeviceClock clock;
    bool is_read = false;  // the clock from the device's answers, not from its images' arrival
    bool is_distrusted = false;  // its answers do not fit its images
    int misfits = 0;             // images in a row that did not come when the clock says
    int64_t images = 0;          // since the last frame
    int64_t lost = 0;            // images that came broken or not at all; in all
  };

  Place& At(RigPlace place) { return places_[static_cast<size_t>(place)]; }
  void AddImage(RigPlace place, DeviceImage image);
  void AddTime(RigPlace place, int64_t device_ns, int64_t utime);
  void CheckReading(RigPlace place, int64_t sent_ns, int64_t arrived_utime);
  // What happened is told with the next frame; a later trouble does not hide an earlier one.
  void Complain(RigPlace place, const std::string& text);
  int64_t LostOf(RigPlace place) const;
  int64_t LostSince(RigPlace place) const;
  int64_t Lost() const;

  RigDescription rig_;
  TripletSynchronizer former_;
  std::array<Place, kRigPlaces.size()> places_;
  bool has_frames_ = false;
  std::array<int64_t, 2> lost_before_{};  // left, right: at the last frame
  std::string trouble_;
  std::string told_;  // of it
};

}  // namespace sprout::capture

#endif  // SPROUT_SERVICES_CAPTURE_GENICAM_FRAME_BUILDER_H_
