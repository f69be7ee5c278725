#ifndef SPROUT_SERVICES_SELFCALIBRATE_FRAME_TAKER_H_
#define SPROUT_SERVICES_SELFCALIBRATE_FRAME_TAKER_H_

#include <functional>
#include <optional>
#include <stop_token>

#include "common/app/service_context.h"
#include "common/app/stage_monitor.h"
#include "common/core/frame.h"
#include "common/frames/frame_joiner.h"

namespace sprout::selfcalibrate {

/// Takes single frames (LEFT, RIGHT, TOF, RIG) from the running graph. Listens only while it waits
/// for one: receiving every frame of 2 MP would take more time than looking at some of them.
class FrameTaker {
 public:
  /// @param monitor  counts messages that are refused.
  FrameTaker(const ServiceContext& context, StageMonitor& monitor)
      : context_(context), monitor_(monitor) {}

  /// The next whole frame that is captured; nothing once a stop is requested.
  /// @param waiting  called at least every Watchdog::kIdlePeriod meanwhile.
  /// @throws BusError when the network cannot be used.
  std::optional<Frame> Take(const std::function<void()>& waiting);

 private:
  static constexpr Part kParts[] = {Part::kLeft, Part::kRight, Part::kTof, Part::kRig};

  const ServiceContext& context_;
  StageMonitor& monitor_;
  // Keeps the calibration, which comes once a second, from one frame to the next.
  FrameJoiner joiner_{PartSet{Part::kLeft, Part::kRight, Part::kTof, Part::kRig}};
};

}  // namespace sprout::selfcalibrate

#endif  // SPROUT_SERVICES_SELFCALIBRATE_FRAME_TAKER_H_
