#ifndef SPROUT_COMMON_APP_PROGRAM_H_
#define SPROUT_COMMON_APP_PROGRAM_H_

#include <functional>
#include <string>

namespace CLI {
class App;  // <CLI/CLI.hpp> takes seconds to compile: for those who add flags
class Validator;
}  // namespace CLI

namespace sprout {

/// For CLI::Option::check(): a number from low to high. CLI::Range would accept NaN.
CLI::Validator NumberIn(double low, double high);

/// What every program's main shares, with or without a bus: parses the flags, runs `body`, and
/// turns errors into one line on stderr that starts with the program's name.
///
/// An empty value is refused, except for --channel-prefix and for a COMMAND. Help is wrapped.
///
/// @param flags  have the program's name.
/// @returns exit code: what `body` returned; 0 for --help and --version; 2 for a flag or
///          configuration that cannot be used (ConfigError); 1 on any other failure, also when
///          something that was printed to std::cout could not be written.
int RunProgram(CLI::App& flags, int argc, const char* const* argv,
               const std::function<int()>& body);

}  // namespace sprout

#endif  // SPROUT_COMMON_APP_PROGRAM_H_
