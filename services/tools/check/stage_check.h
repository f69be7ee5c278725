#ifndef SPROUT_SERVICES_TOOLS_CHECK_STAGE_CHECK_H_
#define SPROUT_SERVICES_TOOLS_CHECK_STAGE_CHECK_H_

#include <chrono>
#include <iosfwd>
#include <string>
#include <vector>

namespace sprout::check {

/// The options of sprout-check-stage.
struct StageCheckOptions {
  std::string stage;                           ///< "capture", or a StageContract's
  std::vector<std::string> command;            ///< the program to check, with arguments
  std::string log;                             ///< with the frames to send; not for capture
  std::string lcm_url;                         ///< a bus without other processes
  std::chrono::milliseconds start_timeout{};   ///< until the first answer or frame
  std::chrono::milliseconds answer_timeout{};  ///< until any other
};

/// Starts the program, sends it frames, ends it, and prints the findings.
/// @returns exit code: 0; 1 when something is wrong with the program.
/// @throws ConfigError for an unknown stage or a log without its frames; LogError; BusError.
int CheckStage(const StageCheckOptions& options, std::ostream& out);

/// Starts a capture process, receives its messages for some seconds, ends it, and prints the
/// findings. Needs no log.
/// @returns exit code: 0; 1 when something is wrong with the program.
/// @throws ConfigError when it cannot be started; BusError.
int CheckCapture(const StageCheckOptions& options, std::ostream& out);

}  // namespace sprout::check

#endif  // SPROUT_SERVICES_TOOLS_CHECK_STAGE_CHECK_H_
