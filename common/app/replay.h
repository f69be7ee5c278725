#ifndef SPROUT_COMMON_APP_REPLAY_H_
#define SPROUT_COMMON_APP_REPLAY_H_

#include <cstddef>

#include "common/app/service_context.h"
#include "common/core/stage_adapter.h"

namespace sprout {

/// Unfinished frames that a replay keeps: a log of a graph that lags far behind its capture has the
/// last message of a frame long after the first. Live, where memory is short, it is fewer.
inline constexpr size_t kReplayMaxPending = 64;

/// Runs an adapter over logs, on this thread and without a network: every event in order, no frame
/// skipped. Its answers become the events of `options.record`, with the time of the event that
/// completed their frame; no clock enters it, so the same logs give the same bytes. Reports on
/// stderr, and in one line of counts on stdout.
///
/// The first calibration of the logs holds from their start: a stage that ran live knew it before
/// the recording began, while in the log it may come a second late.
///
/// The log appears under its name when it is whole, or when context.stop ends the run early; until
/// then it is called `RECORD.part`, and an older one of that name stays.
///
/// @returns exit code: 0; 1 when the log that was written is not all that it should be: stopped,
///          damage or bad messages in a log, or a frame on which the adapter failed.
/// @throws ConfigError, and leaves nothing behind, when a log cannot be used, holds no frame to
/// work
///         on, or is the one to write; LogError when writing fails.
int RunReplay(const ServiceContext& context, const ReplayOptions& options, StageAdapter& adapter);

}  // namespace sprout

#endif  // SPROUT_COMMON_APP_REPLAY_H_
