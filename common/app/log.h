#pragma once

#include <fmt/core.h>

#include <string>
#include <string_view>

namespace sprout {

// The log of this process. Only log.cc includes spdlog, since compiling it, with all of fmt's
// formatting, takes seconds.

enum class LogLevel { kDebug, kInfo, kWarning, kError, kNone };

/// Sets where lines go, and the lowest level that is written. Before this call all but kDebug go to
/// stdout.
/// @param name        of the process, in each line.
/// @param to_journal  to systemd's journal, with the level, without time and process, which it
///                    knows; otherwise to stderr.
void SetUpLog(const std::string& name, LogLevel lowest, bool to_journal);

/// Lines below this level are not written.
void SetLogLevel(LogLevel lowest);

/// Writes a line.
void LogLine(LogLevel level, std::string_view text);

/// Writes a line made of `format` and its arguments; a single text is written as it is.
template <typename First, typename... Rest>
void LogLine(LogLevel level, fmt::format_string<First, Rest...> format, First&& first,
             Rest&&... rest) {
  LogLine(level, fmt::vformat(format, fmt::make_format_args(first, rest...)));
}

}  // namespace sprout
