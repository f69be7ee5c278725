#ifndef SPROUT_SERVICES_VIEW_BUS_LISTENER_H_
#define SPROUT_SERVICES_VIEW_BUS_LISTENER_H_

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string_view>

#include "common/app/duplicate_watch.h"
#include "common/app/service_context.h"
#include "common/app/silence_watch.h"
#include "common/app/stage_monitor.h"
#include "common/bus/receiver.h"
#include "common/frames/sequence_gaps.h"
#include "services/view/frame_ring.h"
#include "services/view/status_history.h"

namespace sprout::view {

/// Receives all messages of the graph, and stores them in ring and history.
class BusListener {
 public:
  /// @param changed  called on another thread when the ring has a newer frame; must be quick.
  /// @throws BusError.
  BusListener(const ServiceContext& context, FrameRing& ring, StatusHistory& history,
              StageMonitor& monitor, std::function<void()> changed);

 private:
  void OnMessage(std::string_view channel, std::span<const uint8_t> bytes);
  void OnStatus(std::span<const uint8_t> bytes, StageMonitor::Clock::time_point now);
  void OnNewest(StageMonitor::Clock::time_point now);

  FrameRing& ring_;
  StatusHistory& history_;
  StageMonitor& monitor_;
  std::function<void()> changed_;
  SilenceWatch silence_;
  DuplicateWatch duplicates_;
  SequenceGaps gaps_;
  std::optional<int64_t> newest_key_;
  Receiver receiver_;  // last: stops before the rest is destroyed
};

}  // namespace sprout::view

#endif  // SPROUT_SERVICES_VIEW_BUS_LISTENER_H_
