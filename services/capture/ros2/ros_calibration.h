#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/core/result.h"
#include "common/core/rig.h"
#include "common/ros/from_ros.h"
#include "services/capture/ros2/ros_input.h"

namespace sprout::capture {

/// A calibrated rig of ROS 2.
struct RosRig {
  Rig rig;
  /// Pose of the points' sensor in the left rectified frame.
  Eigen::Isometry3d left_from_points = Eigen::Isometry3d::Identity();
};

/// Puts together the calibration of a rig whose images are rectified, from P of both camera_info
/// and the transforms. A lidar's rig has the ToF camera of TofImageFromScan(), in the left camera's
/// place; that of a range image is described by K and D of its own camera_info or, when it is
/// rectified (RosSettings::DepthIsRectified()), by P. One that has the left or right images' own
/// camera_info stands where they do.
class RosCalibration {
 public:
  explicit RosCalibration(RosSettings settings) : settings_(std::move(settings)) {}

  /// Looks at a message. @returns whether the calibration is another one with it. An error says
  /// what of it cannot be used; then the calibration stays.
  Result<bool> Take(const RosBytes& message);

  /// The first topic that something is missing of; nothing when all is there.
  std::optional<RosRole> Missing() const;

  /// Which transform is missing, and which there are. @pre Missing() is RosRole::kTf.
  std::string MissingTransform() const;

  /// The rig. An error says what does not fit together. @pre nothing is missing.
  Result<RosRig> Rig() const;

  /// A warning about a range image that names another frame than its CameraInfo, which places it;
  /// empty: none. O(1) where the frames are equal.
  std::string OtherFrame(const RosBytes& message) const;

  /// A warning about images that are taken for rectified, though neither their topic's name nor
  /// their CameraInfo, which moves pixels, says so; empty: none. @pre nothing is missing.
  std::string RawImages() const;

  /// Stamp of the newest CameraInfo that changed something, µs.
  int64_t changed_utime() const { return changed_utime_; }

 private:
  struct Named {
    RosCamera camera;
    std::string frame;
    std::vector<uint8_t> cdr;  // of the message without its stamp
  };
  Result<bool> TakeInfo(const RosBytes& message, std::optional<Named>& to);
  Result<bool> TakePointsFrame(const RosBytes& message);
  Result<bool> TakeTransforms(const RosBytes& message);
  std::optional<RosPose> PoseInRoot(std::string_view frame) const;
  std::optional<Pose> LeftFrom(const std::string& frame) const;
  const std::string& RangeFrame() const;
  std::optional<Pose> LeftFromRange() const;
  Result<TofCamera> DepthCamera(const RectifiedPair& pair) const;

  RosSettings settings_;
  std::optional<Named> left_;
  std::optional<Named> right_;
  std::optional<Named> depth_;
  std::optional<std::string> points_frame_;
  std::vector<uint8_t> points_frame_cdr_;  // as messages have it
  std::map<std::string, RosPose> poses_;   // by child
  std::set<std::string> unusable_;         // children whose newest transform is no pose
  std::set<std::string> moved_;            // children that came with another parent before
  int64_t changed_utime_ = 0;
};

/// Watches whether a rig's CameraInfo, /tf_static or the frame of its points change while it runs:
/// a driver was set to another mode, a camera was calibrated again.
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

  std::string OtherFrame(const RosBytes& message) const { return calibration_.OtherFrame(message); }

  std::string RawImages() const { return calibration_.RawImages(); }

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
