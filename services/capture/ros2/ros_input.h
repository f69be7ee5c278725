#ifndef SPROUT_SERVICES_CAPTURE_ROS2_ROS_INPUT_H_
#define SPROUT_SERVICES_CAPTURE_ROS2_ROS_INPUT_H_

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "common/ros2/ros_type.h"
#include "services/capture/ros2/ros_settings.h"
#include "services/datasets/frame_source.h"

namespace sprout::capture {

/// A message of one of the rig's topics; the bytes are valid until the next one.
struct RosBytes {
  RosRole role = RosRole::kLeft;
  bool is_compressed = false;  ///< an image or a range image: CompressedImage, not Image
  std::span<const uint8_t> cdr;
};

/// The types that a topic may have; those of images are plain and compressed.
std::vector<const RosType*> TypesOf(RosRole role);

/// Reports one line to people.
using TellPeople = std::function<void(const std::string&)>;

/// Where the messages of a rig's topics come from: DDS, or a file.
class RosInput {
 public:
  virtual ~RosInput() = default;
  virtual bool is_live() const = 0;

  /// Waits for the next message. @returns false at the end of a file, and when a stop was asked
  /// for.
  virtual bool Next(RosBytes& message, const std::stop_token& stop) = 0;

  /// What people should know of how topics were found; empty: nothing.
  virtual std::string Note() const { return {}; }

  /// What there is instead of a topic without messages, for a line: "topics there: /a, /b".
  virtual std::string Instead(RosRole role) = 0;
};

/// Subscribes to the topics. Silent ones are reported after 5 s and each minute, with their
/// publishers; so are several publishers of one topic.
/// @throws ConfigError when DDS cannot be used.
std::unique_ptr<RosInput> ListenToRos(const RosSettings& settings, TellPeople tell,
                                      datasets::Waiting waiting);

/// Reads the topics from settings.file, in the order of their log times. Damage is reported.
/// @throws ConfigError when it is no MCAP file, when a topic is not in it, with those that are, or
///         when its type or encoding is another.
std::unique_ptr<RosInput> ReadRosFile(const RosSettings& settings, TellPeople tell);

}  // namespace sprout::capture

#endif  // SPROUT_SERVICES_CAPTURE_ROS2_ROS_INPUT_H_
