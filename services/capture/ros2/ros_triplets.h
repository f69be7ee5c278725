#pragma once

#include <array>
#include <deque>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/picture/eight_bits.h"
#include "common/scenes/frame_source.h"
#include "services/capture/ros2/ros_input.h"
#include "services/capture/triplet_synchronizer.h"

namespace sprout::capture {

/// How a cloud becomes a range image.
using ImageOfPoints = std::function<TofImage(const std::vector<Eigen::Vector3d>&)>;

/// Whether clouds have points in the left image at all: a turned frame, a transform or points in mm
/// leave none, and the empty range image does not say why.
class CloudWatch {
 public:
  /// @param count  points of the cloud; of these `usable` are finite and within 1000 m.
  void Add(size_t count, size_t usable, std::string_view frame, const TofImage& image);

  /// One line when none of the clouds so far had a point there, or any; again after 10, 100, 1000
  /// ... of them, `at_end`: of any; else nothing. O(1).
  std::string Trouble(const std::string& topic, bool at_end);

 private:
  int64_t clouds_ = 0;
  bool has_hit_ = false;
  int64_t next_report_ = 10;
  size_t count_ = 0;  // of the newest cloud
  size_t usable_ = 0;
  std::string frame_;
};

/// Makes triplets of messages: decodes images, puts together those whose stamps are near, counts
/// what found no partner or cannot be used.
class RosTriplets {
 public:
  /// @param size        of the images; nothing: any.
  /// @param range_size  of the range images; nothing: any.
  /// @param image       of points; empty: points are ignored.
  RosTriplets(const RosSettings& settings, std::optional<cv::Size> size,
              std::optional<cv::Size> range_size, ImageOfPoints image);

  /// An error says why an image cannot be used: also one with the stamp of the one before it.
  Result<void> Take(const RosBytes& message);

  /// From now on images have these sizes, and points become this image.
  void Use(cv::Size size, std::optional<cv::Size> range_size, ImageOfPoints image);

  /// No more messages come: pairs that wait for a range image become frames without one.
  void Finish() { is_finished_ = true; }

  /// The next frame, with what was lost before it.
  std::optional<scenes::CapturedFrame> Next();

  /// What was lost since the last frame; at the end also why no range image has ever joined, or
  /// most images became no frame.
  scenes::LostFrames TakeLost() { return LostSince(/*at_end=*/is_finished_); }

 private:
  Result<void> NoteStamp(std::deque<int64_t>& stamps, int64_t utime);
  Result<TimedImage> Decode(const RosBytes& message);
  Result<TimedImage> DecodePoints(const RosBytes& message);
  std::string WhyUnpaired() const;
  std::string WhyMostAreLost() const;
  scenes::LostFrames LostSince(bool at_end);

  std::optional<cv::Size> size_;
  std::optional<cv::Size> range_size_;
  ImageOfPoints image_of_points_;
  std::array<std::string, 2> topics_;  // of left and right
  std::string sensor_;                 // topic of its messages
  TripletSynchronizer synchronizer_;
  EightBits eight_bits_;
  // Stamp of the newest image of left or right, the only clock here. Senders set theirs back (NTP,
  // a bag that begins again), or send one stamp that is wrong: so not the largest one.
  int64_t newest_utime_ = 0;
  int64_t unpaired_ = 0;  // reported so far
  // Stamps of the newest images of left and right. Before both came nothing is missing: topics are
  // found one by one.
  std::array<std::deque<int64_t>, 2> stamps_;
  std::array<std::deque<int64_t>, 2> first_stamps_;
  std::array<int64_t, 2> came_{};  // messages of left and right
  bool begins_ = true;             // until both cameras have sent an image
  double max_spread_ms_;
  CloudWatch cloud_watch_;
  std::string trouble_;
  std::string range_trouble_;  // of the newest range image that cannot be used
  std::string refusal_;        // the same of left and right
  bool is_finished_ = false;
};

}  // namespace sprout::capture
