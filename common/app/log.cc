#include "common/app/log.h"

#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/sinks/systemd_sink.h>
#include <spdlog/spdlog.h>

#include <memory>
#include <utility>

#include "common/core/printable.h"

namespace sprout {
namespace {

spdlog::level::level_enum ToSpdlog(LogLevel level) {
  switch (level) {
    case LogLevel::kDebug:
      return spdlog::level::debug;
    case LogLevel::kInfo:
      return spdlog::level::info;
    case LogLevel::kWarning:
      return spdlog::level::warn;
    case LogLevel::kError:
      return spdlog::level::err;
    case LogLevel::kNone:
      break;
  }
  return spdlog::level::off;
}

}  // namespace

void SetUpLog(const std::string& name, LogLevel lowest, bool to_journal) {
  spdlog::sink_ptr sink;
  if (to_journal) {
    sink = std::make_shared<spdlog::sinks::systemd_sink_mt>("sprout-" + name);
  } else {
    sink = std::make_shared<spdlog::sinks::stderr_color_sink_mt>();
  }
  // Not spdlog::stderr_color_mt(), which throws when a logger of that name exists.
  auto logger = std::make_shared<spdlog::logger>(name, std::move(sink));
  logger->set_level(ToSpdlog(lowest));
  logger->set_pattern("%H:%M:%S.%e %^%L%$ [%n] %v");
  spdlog::set_default_logger(std::move(logger));
}

void SetLogLevel(LogLevel lowest) { spdlog::set_level(ToSpdlog(lowest)); }

void LogLine(LogLevel level, std::string_view text) {
  const std::string printable = PrintableLines(text);
  spdlog::default_logger_raw()->log(ToSpdlog(level), spdlog::string_view_t(printable));
}

}  // namespace sprout
