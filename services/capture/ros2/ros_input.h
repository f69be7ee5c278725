#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "common/ros/ros_type.h"
#include "common/scenes/frame_source.h"
#include "services/capture/ros2/ros_settings.h"

namespace sprout::capture {

/// A message of one of the rig's topics; the bytes are valid until the next one.
struct RosBytes {
  RosRole role = RosRole::kLeft;
  bool is_compressed = false;  ///< an image or a range image: CompressedImage, not Image
  std::span<const uint8_t> cdr;
};

/// The types that a topic may have; those of images are plain and compressed.
std::vector<const RosType*> TypesOf(RosRole role);

/// Callbacks by which a source reports what happens.
struct RosReports {
  /// A line for people; not empty.
  std::function<void(const std::string& line)> tell;
  /// A message of a topic that cannot be used; to be counted. May be empty.
  std::function<void(const std::string& topic, const std::string& why)> refused = {};
  /// Images without partners, when no frame comes that could say it. May be empty.
  std::function<void(const scenes::LostFrames& lost)> lost = {};

  void Refuse(const std::string& topic, const std::string& why) const {
    if (refused) refused(topic, why);
  }
};

/// How large messages may be.
struct RosLimits {
  size_t image_bytes = size_t{256} << 20;
  size_t range_bytes = size_t{64} << 20;  ///< two million points of 32 bytes
};

/// Where the messages of a rig's topics come from: DDS, or a file.
class RosInput {
 public:
  using Clock = std::chrono::steady_clock;
  virtual ~RosInput() = default;
  virtual bool is_live() const = 0;

  /// Before this call only the messages of a calibration need to come. From this call on all
  /// messages come, those of a file from its begin; messages larger than the limits are refused.
  virtual void StartImages(const RosLimits& limits) = 0;

  /// Waits for the next message. @returns false at the end of a file, when a stop was asked for,
  /// and live at the deadline: files have no clock.
  virtual bool Next(RosBytes& message, const std::stop_token& stop,
                    Clock::time_point deadline = Clock::time_point::max()) = 0;

  /// A line for people about how topics were found; empty: nothing.
  virtual std::string Note() const { return {}; }

  /// The topics that there are, for a line about one without messages: "topics there: /a, /b".
  virtual std::string Alternatives(RosRole role) = 0;
};

/// Subscribes to the topics, with the reliability and durability that their publishers offer.
/// Silent ones are reported after 5 s and each minute, with their publishers; so are several
/// publishers that send on one topic, and a policy that keeps a publisher and us apart.
/// @throws ConfigError when DDS cannot be used.
std::unique_ptr<RosInput> ListenToRos(const RosSettings& settings, RosReports reports,
                                      scenes::Waiting waiting);

/// Reads the topics from settings.file, in the order of their log times. Damage is reported.
/// @throws ConfigError when it is no MCAP file, when a topic is not in it, with those that are, or
///         when its type or encoding is another.
std::unique_ptr<RosInput> ReadRosFile(const RosSettings& settings, RosReports reports);

}  // namespace sprout::capture
