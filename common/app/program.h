#pragma once

#include <exception>
#include <functional>
#include <string>

#include "common/app/flags.h"

namespace sprout {

/// What every program's main shares, with or without a bus: adds --version, parses the flags, runs
/// `body`, and turns errors into one line on stderr that starts with the program's name.
///
/// @returns exit code: what `body` returned; 0 for --help and --version; 2 for a flag or
///          configuration that cannot be used (ConfigError); 1 on any other failure, also when
///          something that was printed to std::cout could not be written.
int RunProgram(Flags& flags, int argc, const char* const* argv, const std::function<int()>& body);

/// For programs whose flags name logs: a LogError of `body` becomes a ConfigError, so exit code 2.
int RefusingLogs(const std::function<int()>& body);

/// @throws ConfigError when the value of --channel-prefix cannot be the prefix of every channel.
void RequireChannelPrefix(const std::string& prefix);

/// For a failure due to a limit of this process, for which the system only says "Resource
/// temporarily unavailable" or "std::bad_alloc": names the limit, as ": ..." to append to the
/// message. Otherwise empty.
std::string ReachedLimitText(const std::exception& failure);

}  // namespace sprout
