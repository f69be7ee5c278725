#ifndef SPROUT_COMMON_APP_LOG_H_
#define SPROUT_COMMON_APP_LOG_H_

#include <fmt/core.h>

#include <string>
#include <string_view>

namespace sprout {

// Lines of the log of this process. spdlog stays behind log.cc: whoever includes it compiles it,
// and all of fmt's formatting with it.

enum class LogLevel { kDebug, kInfo, kWarning, kError, kNone };

/// Where lines go from now on, and which. Before that, all but kDebug to stdout.
/// @param name        of the process, in each line.
/// @param to_journal  systemd's, which is told the level and knows time and process; else stderr.
void SetUpLog(const std::string& name, LogLevel lowest, bool to_journal);

/// Lines below this level are not written.
void SetLogLevel(LogLevel lowest);

/// Writes a line.
void LogLine(LogLevel level, std::string_view text);

/// Writes a line made of `format` and what follows it; a text alone is written as it is.
template <typename First, typename... Rest>
void LogLine(LogLevel level, fmt::format_string<First, Rest...> format, First&& first,
             Rest&&... rest) {
  LogLine(level, fmt::vformat(format, fmt::make_format_args(first, rest...)));
}

}  // namespace sprout

#endif  // SPROUT_COMMON_APP_LOG_H_
