#ifndef SPROUT_SERVICES_CHECK_STAGE_CHECK_H_
#define SPROUT_SERVICES_CHECK_STAGE_CHECK_H_

#include <chrono>
#include <iosfwd>
#include <string>
#include <vector>

namespace sprout::check {

/// What sprout-check-stage is asked for.
struct StageCheckOptions {
  std::string stage;                           ///< "capture", or that of a StageContract
  std::vector<std::string> command;            ///< program and arguments that claim to be it
  std::string log;                             ///< whose frames it gets; not for capture
  std::string lcm_url;                         ///< a bus that nobody else is on
  std::chrono::milliseconds start_timeout{};   ///< until the first answer or frame
  std::chrono::milliseconds answer_timeout{};  ///< until any other
};

/// Starts the program, talks with it, ends it, and writes what was found.
/// @returns exit code: 0; 1 when something is wrong with the program.
/// @throws ConfigError for an unknown stage or a log without its frames; LogError; BusError.
int CheckStage(const StageCheckOptions& options, std::ostream& out);

}  // namespace sprout::check

#endif  // SPROUT_SERVICES_CHECK_STAGE_CHECK_H_
