#ifndef SPROUT_SERVICES_CAPTURE_ROS2_ROS_CALIBRATION_H_
#define SPROUT_SERVICES_CAPTURE_ROS2_ROS_CALIBRATION_H_

#include <map>
#include <optional>
#include <string>

#include "common/core/result.h"
#include "common/core/rig.h"
#include "common/ros2/from_ros.h"
#include "services/capture/ros2/ros_input.h"

namespace sprout::capture {

/// A calibrated rig of ROS 2.
struct RosRig {
  Rig rig;
  /// Where the points' sensor stands: in the left rectified frame.
  Eigen::Isometry3d left_from_points = Eigen::Isometry3d::Identity();
};

/// Puts together the calibration of a rig whose images are rectified, from P of both camera_info
/// and the transforms. A lidar's rig has the ToF camera of TofImageFromScan(), in the left camera's
/// place; that of a range image is described by K and D of its own camera_info or, when it is
/// rectified (RosSettings::DepthIsRectified()), by P. One that has the left or right images' own
/// camera_info stands where they do.
class RosCalibration {
 public:
  explicit RosCalibration(const RosSettings& settings) : settings_(settings) {}

  /// Looks at a message. An error says what of it cannot be used.
  Result<void> Take(const RosBytes& message);

  /// The first topic that something is missing of; nothing when all is there.
  std::optional<RosRole> Missing() const;

  /// Which transform is missing, and which there are. @pre Missing() is RosRole::kTf.
  std::string MissingTransform() const;

  /// The rig. An error says what does not fit together. @pre nothing is missing.
  Result<RosRig> Rig() const;

 private:
  struct Named {
    RosCamera camera;
    std::string frame;
  };
  Result<void> TakeInfo(const RosBytes& message, std::optional<Named>& to);
  std::optional<RosPose> PoseInRoot(std::string frame) const;
  std::optional<Pose> LeftFrom(const std::string& frame) const;
  const std::string& RangeFrame() const;
  std::optional<Pose> LeftFromRange() const;
  Result<TofCamera> DepthCamera(const RectifiedPair& pair) const;

  const RosSettings& settings_;
  std::optional<Named> left_;
  std::optional<Named> right_;
  std::optional<Named> depth_;
  std::optional<std::string> points_frame_;
  std::map<std::string, RosPose> poses_;  // by child
};

}  // namespace sprout::capture

#endif  // SPROUT_SERVICES_CAPTURE_ROS2_ROS_CALIBRATION_H_
