#include "tests/common/app/captured_log.h"

#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/ringbuffer_sink.h>
#include <spdlog/spdlog.h>

namespace sprout {

struct CapturedLog::State {
  // More lines than any test logs.
  std::shared_ptr<spdlog::sinks::ringbuffer_sink_mt> lines =
      std::make_shared<spdlog::sinks::ringbuffer_sink_mt>(10'000);
  std::shared_ptr<spdlog::logger> before = spdlog::default_logger();
};

CapturedLog::CapturedLog() : state_(std::make_unique<State>()) {
  auto logger = std::make_shared<spdlog::logger>("captured", state_->lines);
  logger->set_formatter(std::make_unique<spdlog::pattern_formatter>(
      "%l: %v", spdlog::pattern_time_type::local, /*eol=*/""));
  spdlog::set_default_logger(std::move(logger));
}

CapturedLog::~CapturedLog() { spdlog::set_default_logger(state_->before); }

std::vector<std::string> CapturedLog::Lines() const { return state_->lines->last_formatted(); }

}  // namespace sprout
