#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "common/app/service_context.h"
#include "common/app/stage_monitor.h"
#include "common/bus/publisher.h"
#include "common/core/process_info.h"
#include "common/core/stage_status.h"

namespace sprout {

/// Publishes SPROUT_STATUS at once, every second, and a last time when it is destroyed, and
/// SPROUT_PROCESS at once and every kInfoPeriod; on a thread and a connection of its own, so that a
/// busy or stuck stage still reports. The service manager is told about the stage that the process
/// is named after, not about the steps of a combined one.
class StatusReporter {
 public:
  /// Often enough that even a short recording has SPROUT_PROCESS; it takes some 6 kB.
  static constexpr std::chrono::seconds kInfoPeriod{2};

  /// @throws BusError, see OpenLcm().
  StatusReporter(const ServiceContext& context, StageMonitor& monitor);
  ~StatusReporter();

  StatusReporter(const StatusReporter&) = delete;
  StatusReporter& operator=(const StatusReporter&) = delete;

 private:
  void Publish(std::string_view channel, std::span<const uint8_t> bytes);
  void PublishStatus();

  std::string process_;  // its stage
  StageMonitor& monitor_;
  Publisher publisher_;
  std::vector<uint8_t> info_;  // SPROUT_PROCESS
  std::jthread thread_;
};

/// What a live process publishes on SPROUT_PROCESS.
ProcessInfo LiveProcessInfo(const StageStatus& status, const SproutConfig& config);

/// What a replay writes: nothing about the machine. Capture's source, which a stage does not use,
/// has its default.
/// @param utime  of the event that completes the first frame.
ProcessInfo ReplayProcessInfo(const ServiceContext& context, int64_t utime);

/// One line that names the keys that differ if a recorded process of this stage had another
/// effective configuration than `context`; otherwise nothing.
std::optional<std::string> ConfigChangeText(const ServiceContext& context,
                                            const ProcessInfo& recorded);

}  // namespace sprout
