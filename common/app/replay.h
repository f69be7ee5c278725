#pragma once

#include <cstddef>

#include "common/app/service_context.h"
#include "common/core/stage_adapter.h"

namespace sprout {

/// Most unfinished frames of a replay: in a log of a graph that lags far behind its capture the
/// last message of a frame comes long after the first. Live there are fewer, to save memory.
inline constexpr size_t kReplayMaxPending = 64;

/// Runs an adapter on logs, on this thread and without a network: every event in order, no frame
/// skipped. Its answers become the events of `options.record`, with the time of the event that
/// completed their frame. No clock is used, so the same logs give the same bytes. Reports on
/// stderr, and in one line of counts on stdout.
///
/// The first calibration of the logs holds from their start: a stage that ran live knew it before
/// the recording began, while in the log it may come a second late.
///
/// A stage with memory also gets the frames before `options.frames` that it needs to warm up
/// (StageAdapter::WarmUpFrames()); their answers are not recorded.
///
/// The log appears when it is complete, or context.stop ends the run early; until then an older log
/// of that name stays.
///
/// @returns exit code: 0; 1 when the written log is incomplete: stopped, damage or bad messages in
///          a log, or a frame on which the adapter failed; 1 also when all frames are degenerate.
/// @throws ConfigError, and leaves nothing behind, when a log cannot be used, has no frame to
///         process, or is also the output; LogError when writing fails.
int RunReplay(const ServiceContext& context, const ReplayOptions& options, StageAdapter& adapter);

}  // namespace sprout
