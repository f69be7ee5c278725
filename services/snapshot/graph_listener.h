#ifndef SPROUT_SERVICES_SNAPSHOT_GRAPH_LISTENER_H_
#define SPROUT_SERVICES_SNAPSHOT_GRAPH_LISTENER_H_

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <span>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

#include "common/app/frame_assembler.h"
#include "common/app/service_context.h"
#include "common/app/stage_monitor.h"
#include "common/bus/receiver.h"
#include "common/core/frame.h"
#include "common/core/stage_status.h"
#include "common/messages/codec.h"

namespace sprout::snapshot {

/// Listens to everything the graph says and keeps the newest whole frame and the newest status of
/// each stage, of up to 32. Thread-safe.
class GraphListener {
 public:
  using Deadline = StageMonitor::Clock::time_point;

  /// @throws BusError, see OpenLcm().
  GraphListener(const ServiceContext& context, StageMonitor& monitor);

  /// Waits for so many frames with all their parts.
  /// @returns how many there are: fewer when the deadline passed or a stop was requested.
  int64_t WaitForFrames(int64_t count, Deadline deadline, const std::stop_token& stop);

  /// The newest whole frame, with those of the parts that a graph need not have (SPROUT_UNFILLED,
  /// SPROUT_CONFIDENCE) that came before the deadline. Later frames are not kept any more.
  std::optional<Frame> TakeNewest(Deadline deadline, const std::stop_token& stop);

  /// Channels that a frame needs and that nothing came on.
  std::vector<std::string> SilentChannels() const;

  /// Waits until every stage has reported a frame ≥ seq, then gives the newest status of each.
  std::map<std::string, StageStatus> WaitForStatuses(int64_t seq, Deadline deadline,
                                                     const std::stop_token& stop);

 private:
  void OnMessage(std::string_view channel, std::span<const uint8_t> bytes);
  void OnStatus(std::span<const uint8_t> bytes);
  void OnOptional(Part part, std::span<const uint8_t> bytes);
  void AddOptionals();

  StageMonitor& monitor_;
  FrameAssembler assembler_;
  mutable std::mutex mutex_;
  std::condition_variable_any changed_;
  std::set<std::string, std::less<>> heard_;          // channels
  std::set<int64_t> seqs_;                            // of whole frames
  std::map<Part, std::deque<DecodedPart>> optional_;  // the newest few: they come before the others
  bool taken_ = false;
  std::optional<Frame> newest_;
  std::map<std::string, StageStatus> statuses_;
  Receiver receiver_;  // last: stops before the rest is destroyed
};

}  // namespace sprout::snapshot

#endif  // SPROUT_SERVICES_SNAPSHOT_GRAPH_LISTENER_H_
