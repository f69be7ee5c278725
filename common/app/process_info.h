#ifndef SPROUT_COMMON_APP_PROCESS_INFO_H_
#define SPROUT_COMMON_APP_PROCESS_INFO_H_

#include <cstdint>
#include <optional>
#include <string>

#include "common/app/service_context.h"
#include "common/core/process_info.h"
#include "common/core/stage_status.h"

namespace sprout {

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

#endif  // SPROUT_COMMON_APP_PROCESS_INFO_H_
