#include <chrono>
#include <cstdint>

#include "common/app/program.h"
#include "common/bus/lcm_url.h"
#include "common/config/config_error.h"
#include "services/tools/check/checks.h"

namespace sprout::check {
namespace {

using std::chrono::milliseconds;

constexpr char kDescription[] =
    "Checks whether a program can replace a stage: starts it, sends it the frames of a log, "
    "and\nchecks every answer. For capture it starts the program and checks what it "
    "sends.\nscripts/check_stage runs it on a private network.";

milliseconds Milliseconds(double seconds) {
  return milliseconds(static_cast<int64_t>(seconds * 1000));
}

int Main(int argc, char** argv) {
  Flags flags("sprout-check-stage", kDescription);
  CheckOptions options;
  double start_s = 30;
  double answer_s = 10;
  flags.Add("STAGE", options.stage, "capture, refine, prior, grow, temporal or pipeline")
      .Required();
  flags.Add("COMMAND", options.command, "Program and its arguments, after --").Required();
  flags.Add("--log", options.log,
            "Log with every channel of the graph; needed unless STAGE is capture");
  flags
      .Add("--lcm-url", options.lcm_url,
           "A bus without other processes; the program gets it as LCM_DEFAULT_URL")
      .ShowDefault();
  flags
      .Add("--start-timeout", start_s,
           "Longest wait for the first answer, or capture's first frame, s")
      .Within(0.1, 3600.0)
      .ShowDefault();
  flags.Add("--timeout", answer_s, "Longest wait for any other answer or frame, s")
      .Within(0.01, 3600.0)
      .ShowDefault();
  return RunProgram(flags, argc, argv, [&] {
    options.start_timeout = Milliseconds(start_s);
    options.answer_timeout = Milliseconds(answer_s);
    try {
      return RefusingLogs(
          [&] { return options.stage == "capture" ? CheckCapture(options) : CheckStage(options); });
    } catch (const BusError& e) {
      throw ConfigError(e.what());
    }
  });
}

}  // namespace
}  // namespace sprout::check

int main(int argc, char** argv) { return sprout::check::Main(argc, argv); }
