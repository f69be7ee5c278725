#pragma once

#include <span>

#include "common/app/service_context.h"
#include "common/app/stage_monitor.h"
#include "common/core/stage_adapter.h"

namespace sprout {

/// Runs an adapter on the live bus until context.stop: one thread receives, decodes and joins; this
/// one processes the newest complete frame and publishes the answer; a third reports the status
/// once a second. Of the frames that come while the adapter is busy only the newest is kept; the
/// others are skipped and counted.
/// @param steps  of an adapter that combines several stages: one monitor for each, whose statuses
///               are published beside its own.
/// @throws BusError when the network cannot be used.
void RunLive(const ServiceContext& context, StageAdapter& adapter,
             std::span<StageMonitor> steps = {});

}  // namespace sprout
