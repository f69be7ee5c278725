#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "common/app/process.h"
#include "common/bus/channels.h"
#include "common/bus/lcm_url.h"
#include "common/bus/publisher.h"
#include "common/bus/receiver.h"
#include "common/core/frame.h"
#include "common/core/stage_status.h"
#include "tests/system/eventually.h"

namespace sprout {

/// The stages between capture and disparity.
inline constexpr const char* kChain[] = {"refine", "prior", "grow"};

/// The processes of a graph and what they say, on the network that the test runs in.
class Graph {
 public:
  /// @param url       where the graph's messages travel.
  /// @param channels  what is received; statuses alone where large frames would fill the memory.
  explicit Graph(std::string prefix = "", std::string url = kDefaultLcmUrl,
                 const std::vector<std::string_view>& channels = AllChannels());

  /// Starts sprout-STAGE and waits for its first status.
  Process& Start(const std::string& stage, std::vector<std::string> flags = {});

  /// Starts sprout-STAGE without waiting.
  Process& StartOnly(const std::string& stage, std::vector<std::string> flags = {});

  /// Starts the stages of kChain, and waits for their first statuses.
  void StartChain(const std::vector<std::string>& flags = {"--config", "default"});

  /// Runs sprout-capture to its end, with all stages that were started before it: each frame is
  /// sent when the one before is answered.
  /// @throws std::runtime_error when it fails, or takes longer than `timeout`.
  void Capture(std::vector<std::string> flags,
               std::chrono::seconds timeout = std::chrono::seconds(30));

  Process& process(const std::string& stage) { return *processes_.at(stage); }

  /// Waits for a condition on what was received; false after `timeout`.
  bool WaitUntil(const std::function<bool(Graph&)>& condition,
                 std::chrono::seconds timeout = std::chrono::seconds(30));

  /// Shows what was received so far.
  void Look(const std::function<void(Graph&)>& look);

  /// Sends any bytes on a channel.
  void Publish(std::string_view channel, std::span<const uint8_t> bytes);
  void PublishPart(const FrameId& id, Part part, const PartValue& value);
  /// Sends what capture sends of a frame, with the name of the rig.
  void PublishFrame(int64_t utime, int64_t seq, const Rig& rig, const cv::Mat& left,
                    const cv::Mat& right, const TofImage& tof);

  // What was received; only inside WaitUntil() and Look(), or when no process is running.
  std::map<std::string, StageStatus> statuses;          // newest of each stage
  std::map<std::pair<Part, int64_t>, PartValue> parts;  // newest by (part, seq)
  std::map<std::pair<Part, int64_t>, int> part_counts;  // how often each came

 private:
  void OnMessage(std::string_view channel, std::span<const uint8_t> bytes);

  std::string prefix_;
  std::string url_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::map<std::string, std::unique_ptr<Process>> processes_;
  Publisher publisher_;
  Receiver receiver_;
};

}  // namespace sprout
