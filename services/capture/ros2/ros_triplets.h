#ifndef SPROUT_SERVICES_CAPTURE_ROS2_ROS_TRIPLETS_H_
#define SPROUT_SERVICES_CAPTURE_ROS2_ROS_TRIPLETS_H_

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "services/capture/genicam/triplet_synchronizer.h"
#include "services/capture/ros2/ros_input.h"
#include "services/datasets/frame_source.h"

namespace sprout::capture {

/// How a cloud becomes a range image.
using ImageOfPoints = std::function<TofImage(const std::vector<Eigen::Vector3d>&)>;

/// Makes triplets of messages: decodes images, puts together those whose stamps are near, counts
/// what found no partner or cannot be used.
class RosTriplets {
 public:
  /// @param size   of the images; nothing: any.
  /// @param image  for points; empty: they are left alone.
  RosTriplets(const RosSettings& settings, std::optional<cv::Size> size, ImageOfPoints image);

  void Take(const RosBytes& message);

  /// No more messages come: what waits for a range image goes without.
  void Finish() { is_finished_ = true; }

  /// The next frame, with what was lost before it.
  std::optional<datasets::CapturedFrame> Next();

  /// What was lost since then.
  datasets::LostFrames TakeLost();

 private:
  Result<TimedImage> Decode(const RosBytes& message) const;
  Result<TimedImage> DecodePicture(const RosBytes& message) const;

  std::optional<cv::Size> size_;
  ImageOfPoints image_of_points_;
  TripletSynchronizer synchronizer_;
  int64_t newest_utime_ = 0;  // of any stamp: the only clock here
  int64_t unpaired_ = 0;      // reported so far
  std::string trouble_;
  bool is_finished_ = false;
};

}  // namespace sprout::capture

#endif  // SPROUT_SERVICES_CAPTURE_ROS2_ROS_TRIPLETS_H_
