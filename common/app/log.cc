#include "common/app/log.h"

#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include <memory>
#include <utility>

#include "common/core/printable.h"

namespace sprout {
namespace {

// In the order of LogLevel.
constexpr spdlog::level::level_enum kLevels[] = {spdlog::level::debug, spdlog::level::info,
                                                 spdlog::level::warn, spdlog::level::err,
                                                 spdlog::level::off};

spdlog::level::level_enum ToSpdlog(LogLevel level) { return kLevels[static_cast<size_t>(level)]; }

// What systemd reads of a program's stderr: each line with its syslog level (sd-daemon(3)).
class JournalLines : public spdlog::formatter {
 public:
  void format(const spdlog::details::log_msg& message, spdlog::memory_buf_t& out) override {
    std::string_view rest(message.payload.data(), message.payload.size());
    for (bool is_more = true; is_more;) {
      const size_t end = rest.find('\n');
      is_more = end != std::string_view::npos;
      const std::string line =
          fmt::format("<{}>{}\n", SyslogLevel(message.level), rest.substr(0, end));
      out.append(line.data(), line.data() + line.size());
      rest = is_more ? rest.substr(end + 1) : "";
    }
  }
  std::unique_ptr<spdlog::formatter> clone() const override {
    return std::make_unique<JournalLines>();
  }

 private:
  static int SyslogLevel(spdlog::level::level_enum level) {
    if (level >= spdlog::level::err) return 3;
    if (level == spdlog::level::warn) return 4;
    return level == spdlog::level::info ? 6 : 7;
  }
};

}  // namespace

void SetUpLog(const std::string& name, LogLevel lowest, bool to_journal) {
  spdlog::sink_ptr sink;
  if (to_journal) {
    sink = std::make_shared<spdlog::sinks::stderr_sink_mt>();
  } else {
    sink = std::make_shared<spdlog::sinks::stderr_color_sink_mt>();
  }
  // spdlog::stderr_color_mt() is not used: it throws when a logger of that name exists.
  auto logger = std::make_shared<spdlog::logger>(name, std::move(sink));
  logger->set_level(ToSpdlog(lowest));
  if (to_journal) {
    logger->set_formatter(std::make_unique<JournalLines>());
  } else {
    logger->set_pattern("%H:%M:%S.%e %^%L%$ [%n] %v");
  }
  spdlog::set_default_logger(std::move(logger));
}

void SetLogLevel(LogLevel lowest) { spdlog::set_level(ToSpdlog(lowest)); }

void LogLine(LogLevel level, std::string_view text) {
  const std::string printable = PrintableLines(text);
  spdlog::default_logger_raw()->log(ToSpdlog(level), spdlog::string_view_t(printable));
}

}  // namespace sprout
