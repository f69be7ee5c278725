#ifndef SPROUT_SERVICES_CAPTURE_ANSWER_TRACKER_H_
#define SPROUT_SERVICES_CAPTURE_ANSWER_TRACKER_H_

#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <set>
#include <span>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

#include "common/app/duplicate_watch.h"
#include "common/app/service_context.h"
#include "common/app/stage_monitor.h"
#include "common/bus/receiver.h"
#include "common/core/frame_id.h"

namespace sprout::capture {

/// Tracks what the graph answers to capture: which stages report, and which frames have a
/// disparity. Thread-safe.
class AnswerTracker {
 public:
  using Deadline = StageMonitor::Clock::time_point;

  /// Subscribes to SPROUT_STATUS and, with `disparities`, to SPROUT_DISPARITY. Stores only what was
  /// asked for, whatever arrives.
  /// @param stages  to wait for.
  /// @throws BusError, see OpenLcm().
  AnswerTracker(const ServiceContext& context, StageMonitor& monitor,
                const std::vector<std::string>& stages, bool disparities);

  /// Waits until every stage has reported.
  /// @returns the stages that have not reported: none, unless the deadline passed or a stop was
  ///          requested.
  std::set<std::string> WaitForStages(Deadline deadline, const std::stop_token& stop);

  /// A frame is about to be sent; an answer with this FrameId is expected.
  void Expect(const FrameId& id);

  bool IsAnswered(const FrameId& id);

  /// Waits until at most `count` of the expected answers are missing, the deadline passes or a stop
  /// is requested.
  void WaitForRoom(size_t count, Deadline deadline, const std::stop_token& stop);

 private:
  void OnMessage(std::string_view channel, std::span<const uint8_t> bytes);
  void OnStatus(std::span<const uint8_t> bytes);
  void OnDisparity(std::span<const uint8_t> bytes);

  StageMonitor& monitor_;
  DuplicateWatch duplicates_;
  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::set<std::string> silent_;  // stages that have not reported
  std::vector<FrameId> missing_;  // expected and not answered
  Receiver receiver_;             // last: stops before the rest is destroyed
};

}  // namespace sprout::capture

#endif  // SPROUT_SERVICES_CAPTURE_ANSWER_TRACKER_H_
