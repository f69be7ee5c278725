#ifndef SPROUT_SERVICES_CAPTURE_RIG_UPDATES_H_
#define SPROUT_SERVICES_CAPTURE_RIG_UPDATES_H_

#include <memory>
#include <span>
#include <stop_token>
#include <string_view>
#include <thread>

#include "common/app/service_context.h"
#include "common/app/stage_monitor.h"
#include "common/bus/mailbox.h"
#include "common/bus/receiver.h"
#include "services/capture/rig_keeper.h"

namespace sprout::capture {

/// Listens to SPROUT_RIG_CHANGE, and lets a RigKeeper put the calibration right, on a thread of its
/// own with low priority, so that no frame waits.
class RigUpdates {
 public:
  /// @param current  null when the source is not rectified here.
  /// @param monitor  is told of every change; must outlive this.
  /// @throws ConfigError as RigKeeper, and when there is nothing that could be changed; BusError.
  RigUpdates(const ServiceContext& context, std::shared_ptr<CurrentRig> current,
             StageMonitor& monitor);

 private:
  void OnMessage(std::span<const uint8_t> bytes);
  void Work(const std::stop_token& stop);

  StageMonitor& monitor_;
  RigKeeper keeper_;
  Mailbox<RigChange> changes_;
  std::jthread worker_;
  Receiver receiver_;  // last: stops before the rest is destroyed
};

}  // namespace sprout::capture

#endif  // SPROUT_SERVICES_CAPTURE_RIG_UPDATES_H_
