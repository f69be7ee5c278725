#include <unistd.h>

#include <cstdint>
#include <iostream>
#include <mutex>

#include "common/app/log.h"
#include "common/app/service.h"
#include "common/app/status_board.h"
#include "common/bus/channels.h"
#include "common/bus/receiver.h"
#include "common/core/reassembly_failures.h"
#include "common/core/sleep.h"
#include "common/messages/codec.h"

namespace sprout::top {
namespace {

using Clock = StatusBoard::Clock;

struct Options {
  std::vector<std::string> stages = {"capture", "refine", "prior", "grow"};
  bool once = false;
  bool json = false;
  double listen_s = 2.5;
};

// Keeps the newest status of every process on the bus.
class Listener {
 public:
  Listener(const ServiceContext& context, const std::vector<std::string>& stages)
      : board_(stages),
        receiver_(context.lcm_url, context.prefix, {kStatusChannel},
                  [this](std::string_view, std::span<const uint8_t> bytes) { OnStatus(bytes); }) {}

  std::vector<BoardRow> Rows() const {
    const std::lock_guard lock(mutex_);
    return board_.Rows(Clock::now());
  }

  LeftOut left_out() const {
    const std::lock_guard lock(mutex_);
    LeftOut left_out = board_.left_out();
    left_out.not_joined = ReassemblyFailures() - failures_before_;
    return left_out;
  }

 private:
  void OnStatus(std::span<const uint8_t> bytes) {
    const Result<StageStatus> status = DecodeStatus(bytes);
    const std::lock_guard lock(mutex_);
    status ? static_cast<void>(board_.Add(*status, Clock::now())) : board_.AddUnreadable();
  }

  mutable std::mutex mutex_;
  int64_t failures_before_ = ReassemblyFailures();
  StatusBoard board_;
  Receiver receiver_;  // last: stops before the rest is destroyed
};

void Show(const Listener& listener, const Options& options, bool screen) {
  const std::vector<BoardRow> rows = listener.Rows();
  if (options.json) {
    std::cout << BoardJson(rows, listener.left_out()) << std::endl;
    return;
  }
  constexpr std::string_view kHome = "\x1b[H\x1b[J";  // cursor to the corner, rest of screen empty
  const std::string text = BoardText(rows, screen) + LeftOutText(listener.left_out());
  std::cout << (screen ? kHome : "") << text << std::flush;
}

int Watch(const ServiceContext& context, const Options& options) {
  const Listener listener(context, options.stages);
  const bool screen = !options.once && !options.json && isatty(STDOUT_FILENO) != 0;
  if (screen) SetLogLevel(LogLevel::kNone);  // log lines would spoil the table
  SleepFor(std::chrono::duration<double>(options.once ? options.listen_s : 1), context.stop);
  do {
    Show(listener, options, screen);
    if (options.once) break;
  } while (std::cout && SleepFor(std::chrono::seconds(1), context.stop));
  return IsWhole(listener.Rows()) ? 0 : 1;
}

int Main(int argc, char** argv) {
  Service service(
      "top",
      "Shows the state of every process of the running graph once a second: newest frame, rate,\n"
      "frames answered, time a frame and age of the answer (ms, median and 99 %), frames that "
      "were\nskipped, incomplete, missing or failed, bad messages, memory, and the share of the "
      "image that\nToF seeds cover. Exit code 1 when one of --stages is missing, stale, "
      "stopped, or\nrunning twice.");
  Options options;
  service.flags()
      .Add("--stages", options.stages, "Stages that must be running")
      .SplitAtCommas()
      .ShowDefault();
  service.flags().Add("--once", options.once, "Print once and end");
  service.flags().Add("--json", options.json, "One line of JSON a second, for scripts");
  service.flags()
      .Add("--listen", options.listen_s, "How long --once listens, s")
      .Within(2.5, 3600.0)  // two statuses of each process: one does not tell what it loses now
      .ShowDefault();
  return service.Run(argc, argv,
                     [&](const ServiceContext& context) { return Watch(context, options); });
}

}  // namespace
}  // namespace sprout::top

int main(int argc, char** argv) { return sprout::top::Main(argc, argv); }
