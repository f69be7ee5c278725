#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "common/bus/lcm_url.h"

namespace sprout::check {

/// What is checked, and how long it may take.
struct CheckOptions {
  std::string stage;                           ///< "capture", or a StageContract's
  std::vector<std::string> command;            ///< program and arguments
  std::string log;                             ///< with the frames; not for capture
  std::string lcm_url = kDefaultLcmUrl;        ///< a bus without other processes
  std::chrono::milliseconds start_timeout{};   ///< to the first answer or frame
  std::chrono::milliseconds answer_timeout{};  ///< to any other one
};

/// Starts a stage, sends it the frames of a log, checks every answer, ends it, and prints the
/// findings to stdout.
/// @returns exit code: 0; 1 when something is wrong with the program.
/// @throws ConfigError when there is no log, or the program cannot be started; BusError.
int CheckStage(const CheckOptions& options);

/// Starts a capture process, receives its messages for some seconds, ends it, and prints the
/// findings to stdout. Needs no log. Returns and throws as CheckStage().
int CheckCapture(const CheckOptions& options);

}  // namespace sprout::check
