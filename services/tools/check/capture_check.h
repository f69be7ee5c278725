#ifndef SPROUT_SERVICES_TOOLS_CHECK_CAPTURE_CHECK_H_
#define SPROUT_SERVICES_TOOLS_CHECK_CAPTURE_CHECK_H_

#include <iosfwd>

#include "services/tools/check/stage_check.h"

namespace sprout::check {

/// Starts a capture process, receives its messages for some seconds, ends it, and prints the
/// findings. Needs no log.
/// @returns exit code: 0; 1 when something is wrong with the program.
/// @throws ConfigError when it cannot be started; BusError.
int CheckCapture(const StageCheckOptions& options, std::ostream& out);

}  // namespace sprout::check

#endif  // SPROUT_SERVICES_TOOLS_CHECK_CAPTURE_CHECK_H_
