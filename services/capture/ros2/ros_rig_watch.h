#ifndef SPROUT_SERVICES_CAPTURE_ROS2_ROS_RIG_WATCH_H_
#define SPROUT_SERVICES_CAPTURE_ROS2_ROS_RIG_WATCH_H_

#include <map>
#include <optional>
#include <string>

#include "services/capture/ros2/ros_calibration.h"
#include "services/capture/ros2/ros_input.h"

namespace sprout::capture {

/// Watches whether a rig's CameraInfo or /tf_static change while it runs: a driver was set to
/// another mode, a camera was calibrated again.
class RosRigWatch {
 public:
  /// @param calibration  complete, with this rig.
  RosRigWatch(RosCalibration calibration, RosRig rig)
      : calibration_(std::move(calibration)), rig_(std::move(rig)) {}

  /// Looks at a message. @returns whether the rig of coming frames is another one. An error: the
  /// message cannot be used; if it is a CameraInfo, no frame can until a better one comes.
  Result<bool> Take(const RosBytes& message);

  /// The rig for a frame of this time, if it is a new one. Messages of different topics overtake
  /// each other: a frame from just before the change keeps the old rig.
  std::optional<RosRig> TakeNewRig(int64_t utime);

  /// Why frames have no calibration now: a CameraInfo that cannot be used, or a new left one whose
  /// right one has not come. Empty: they have one.
  std::string trouble() const;

  /// The rig that the newest messages describe.
  const RosRig& rig() const { return rig_; }

 private:
  RosCalibration calibration_;
  RosRig rig_;
  bool is_new_ = false;
  std::map<RosRole, std::string> refused_;  // newest messages that cannot be used, and why
  std::string misfit_;                      // why the messages make no rig
};

}  // namespace sprout::capture

#endif  // SPROUT_SERVICES_CAPTURE_ROS2_ROS_RIG_WATCH_H_
