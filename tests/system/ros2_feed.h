#pragma once

#include <chrono>
#include <thread>

#include "common/app/stage_monitor.h"
#include "tests/common/messages/examples.h"
#include "tests/system/graph.h"

// Sends the messages that sprout-ros2 shows, in place of the stages.
namespace sprout {

// Receives the statuses alone, not the frames of 8 MB that it sends.
class FedGraph : public Graph {
 public:
  FedGraph() : Graph("", kDefaultLcmUrl, {kStatusChannel}) {}
};

// What capture, grow and depth send, of 2 MP frames where nothing else is said, at 10 Hz.
class FeedGraph {
 public:
  explicit FeedGraph(Graph& graph, cv::Size size = kSize)
      : graph_(graph), left_(cv::Mat1b(size, uint8_t{9})) {
    rig_ = examples::Rig();
    rig_.pair.width = size.width;
    rig_.pair.height = size.height;
    depth_ = {.counts = cv::Mat1w(size, uint16_t{1500}),
              .metres_per_count = 0.001,
              .focal_px = 1000,
              .cx = 960,
              .cy = 540};
    // A point for every fourth pixel of every fourth row.
    cloud_.points.assign(static_cast<size_t>(size.area() / 16),
                         {.position_m = {1, 2, 3}, .bgr = {1, 2, 3}});
  }

  // @returns how many frames.
  int Run(int seconds) {
    const auto begin = std::chrono::steady_clock::now();
    int sent = 0;
    for (; sent < 10 * seconds; ++sent) {
      std::this_thread::sleep_until(begin + sent * std::chrono::milliseconds(100));
      const FrameId id{.utime = NowUtime(), .seq = next_++, .rig_id = RigId(rig_)};
      if (sent % 10 == 0) graph_.PublishPart(id, Part::kRig, rig_);
      graph_.PublishPart(id, Part::kLeft, left_);
      graph_.PublishPart(id, Part::kDepth, depth_);
      graph_.PublishPart(id, Part::kCloud, cloud_);
    }
    return sent;
  }

  /// Leaves frame numbers out.
  void Skip(int64_t count) { next_ += count; }

  static inline const cv::Size kSize{1920, 1080};

 private:
  Graph& graph_;
  Rig rig_;
  cv::Mat left_;
  DepthImage depth_;
  PointCloud cloud_;
  int64_t next_ = 0;
};

// The newest status, once its counts stand still.
inline StageStatus FinalStatus(Graph& graph) {
  std::this_thread::sleep_for(std::chrono::milliseconds(1500));
  StageStatus status;
  graph.Look([&](Graph& g) { status = g.statuses.at("ros2"); });
  return status;
}

}  // namespace sprout
