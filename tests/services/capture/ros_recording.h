#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <utility>
#include <vector>

#include "common/config/config_error.h"
#include "common/ros/frame_topics.h"
#include "common/ros/mcap_writer.h"
#include "services/capture/ros2/ros_source.h"
#include "tests/common/messages/examples.h"
#include "tests/common/picture/temporary_directory.h"
#include "tests/common/testing/thrown.h"

// Recordings of ROS 2's messages for tests, and what is read of them.
namespace sprout::capture {

inline constexpr int64_t kStart = 1'700'000'000'000'000;
inline const cv::Size kSize(640, 480);  // as examples::Rig()

inline std::string PathOf(const TemporaryDirectory& folder) { return folder / "file"; }

inline std::string Source(const TemporaryDirectory& folder, const std::string& options = "") {
  return "mcap:" + PathOf(folder) + "?left=/left/image&right=/right/image" + options;
}

class RosRecording {
 public:
  /// A file in a folder of its own.
  /// @param chunk_bytes  small: each message has a chunk of its own.
  explicit RosRecording(size_t chunk_bytes = size_t{4} << 20)
      : writer_(path(), {.profile = "ros2", .chunk_bytes = chunk_bytes}) {}
  explicit RosRecording(const std::string& path) : writer_(path, {.profile = "ros2"}) {}
  explicit RosRecording(const Rig& rig) : RosRecording() { AddCalibration(rig); }

  /// Adds a topic, which may stay without messages. @returns its channel.
  uint16_t AddTopic(const std::string& topic, const RosType& type) {
    const auto [channel, is_new] = channels_.try_emplace(topic);
    if (is_new) {
      const uint16_t schema = writer_.AddSchema(type.name, "ros2msg", RosSchema(type));
      channel->second = writer_.AddChannel(schema, topic, "cdr");
    }
    return channel->second;
  }

  /// @param time_ns  of the recording, not of the message.
  void Add(const std::string& topic, const AnyRosMessage& message, uint64_t time_ns = 0) {
    const uint16_t channel = AddTopic(topic, message.type());
    WriteCdr(message, cdr_);
    if (change_) change_(cdr_);
    writer_.Write(channel, 0, time_ns, cdr_);
  }

  void AddPairInfo(const Rig& rig, int64_t utime = kStart, const RosFrames& frames = {}) {
    Add("/left/camera_info", ToRosLeftInfo({utime, frames.left}, rig.pair));
    Add("/right/camera_info", ToRosRightInfo({utime, frames.right}, rig.pair));
  }

  /// A range image of examples::Rig(), and its calibration in a frame.
  void AddTof(const std::string& frame = RosFrames().tof) {
    AddImage("/tof/image", kStart, examples::Tof(false).depth_m);
    Add("/tof/camera_info", ToRosTofInfo({kStart, frame}, examples::Rig().tof));
  }

  void AddCalibration(const Rig& rig, const std::string& of_robot = "") {
    AddPairInfo(rig);
    Add(of_robot + "/tf_static", ToRosTransforms(kStart, rig, {}));
  }

  void AddImage(const std::string& topic, int64_t utime, const cv::Mat& image,
                uint64_t time_ns = 0) {
    const bool is_of_tof = topic.starts_with("/tof/");
    Add(topic, ToRosImage({utime, is_of_tof ? RosFrames().tof : "frame"}, image), time_ns);
  }

  /// @param header_bytes  before the picture, zeros.
  void AddPng(const std::string& topic, const std::string& format, const cv::Mat& image,
              size_t header_bytes = 0) {
    std::vector<uint8_t> png;
    cv::imencode(".png", image, png);
    RosMessage<RosCompressedImage> message;
    message->header.stamp = RosStamp(kStart);
    SetRosText(message->format, format);
    std::ranges::copy(png, ResizeRos(message->data, header_bytes + png.size()).begin() +
                               static_cast<std::ptrdiff_t>(header_bytes));
    Add(topic, message);
  }

  void AddPair(int64_t utime, const cv::Mat& image, uint64_t time_ns = 0) {
    AddImage("/left/image", utime, image, time_ns);
    AddImage("/right/image", utime, image, time_ns);
  }

  /// Sets a function that changes the bytes of further messages.
  void Change(std::function<void(std::vector<uint8_t>&)> change) { change_ = std::move(change); }

  void Finish() {
    if (is_finished_) return;
    EXPECT_TRUE(writer_.Commit());
    is_finished_ = true;
  }

  std::string path() const { return PathOf(folder_); }

  /// Finishes the file. @returns the text of a source that names it.
  std::string Source(const std::string& options = "") {
    Finish();
    return capture::Source(folder_, options);
  }

 private:
  const TemporaryDirectory folder_;
  bool is_finished_ = false;
  McapWriter writer_;
  std::map<std::string, uint16_t> channels_;
  std::vector<uint8_t> cdr_;
  std::function<void(std::vector<uint8_t>&)> change_;
};

struct Told {
  std::vector<std::string> lines;
  std::vector<std::string> refused;
  std::vector<scenes::LostFrames> lost;
  RosSourceOptions Options(bool loop = false) {
    return {.loop = loop,
            .reports = {.tell = [this](const std::string& line) { lines.push_back(line); },
                        .refused =
                            [this](const std::string& topic, const std::string& why) {
                              refused.push_back(topic + ": " + why);
                            },
                        .lost = [this](const scenes::LostFrames& of) { lost.push_back(of); }}};
  }
};

inline cv::Mat1b Grey(int value) { return cv::Mat1b(kSize, static_cast<uint8_t>(value)); }

inline std::vector<scenes::CapturedFrame> All(scenes::FrameSource& source) {
  std::vector<scenes::CapturedFrame> frames;
  const std::stop_source never;
  while (auto frame = source.Next(never.get_token())) frames.push_back(std::move(*frame));
  return frames;
}

inline std::string Complaint(const std::string& source) {
  return Thrown<ConfigError>([&] {
    Told told;
    OpenRosSource(source, told.Options());
  });
}

}  // namespace sprout::capture
