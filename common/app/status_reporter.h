#ifndef SPROUT_COMMON_APP_STATUS_REPORTER_H_
#define SPROUT_COMMON_APP_STATUS_REPORTER_H_

#include <thread>

#include "common/app/service_context.h"
#include "common/app/stage_monitor.h"
#include "common/bus/publisher.h"

namespace sprout {

/// Publishes SPROUT_STATUS at once, every second, and a last time when it is destroyed; on a
/// thread and a connection of its own, so that a busy or stuck stage still reports.
class StatusReporter {
 public:
  /// @throws BusError, see OpenLcm().
  StatusReporter(const ServiceContext& context, StageMonitor& monitor);
  ~StatusReporter();

  StatusReporter(const StatusReporter&) = delete;
  StatusReporter& operator=(const StatusReporter&) = delete;

 private:
  void Publish();

  StageMonitor& monitor_;
  Publisher publisher_;
  std::jthread thread_;
};

}  // namespace sprout

#endif  // SPROUT_COMMON_APP_STATUS_REPORTER_H_
