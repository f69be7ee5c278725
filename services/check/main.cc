#include <CLI/CLI.hpp>
#include <iostream>

#include "common/app/program.h"
#include "common/app/version.h"
#include "common/bus/lcm_url.h"
#include "common/config/config_error.h"
#include "common/logfile/log_error.h"
#include "services/check/capture_check.h"
#include "services/check/stage_check.h"

namespace sprout::check {
namespace {

constexpr char kDescription[] =
    "Checks whether a program can replace a stage: starts it, sends it the frames of a log, "
    "and\nchecks every answer. For capture it starts the program and checks what it "
    "sends.\nscripts/check_stage runs it on a private network.";

std::chrono::milliseconds Milliseconds(double seconds) {
  return std::chrono::milliseconds(static_cast<int64_t>(seconds * 1000));
}

int Main(int argc, char** argv) {
  CLI::App flags(kDescription, "sprout-check-stage");
  StageCheckOptions options;
  options.lcm_url = kDefaultLcmUrl;
  double start_s = 30;
  double answer_s = 10;
  flags.add_option("STAGE", options.stage, "capture, refine, prior, grow, temporal or pipeline")
      ->required();
  flags.add_option("COMMAND", options.command, "Program and its arguments, after --")->required();
  flags.add_option("--log", options.log,
                   "Log with every channel of the graph; needed unless STAGE is capture");
  flags
      .add_option("--lcm-url", options.lcm_url,
                  "A bus without other processes; the program gets it as LCM_DEFAULT_URL")
      ->capture_default_str();
  flags
      .add_option("--start-timeout", start_s,
                  "Longest wait for the first answer, or capture's first frame, s")
      ->check(NumberIn(0.1, 3600.0))
      ->capture_default_str();
  flags.add_option("--timeout", answer_s, "Longest wait for any other answer or frame, s")
      ->check(NumberIn(0.01, 3600.0))
      ->capture_default_str();
  flags.set_version_flag("--version", "sprout-check-stage " + Version());
  return RunProgram(flags, argc, argv, [&] {
    options.start_timeout = Milliseconds(start_s);
    options.answer_timeout = Milliseconds(answer_s);
    try {
      if (options.stage == "capture") return CheckCapture(options, std::cout);
      return CheckStage(options, std::cout);
    } catch (const LogError& e) {
      throw ConfigError(e.what());  // exit code 2
    } catch (const BusError& e) {
      throw ConfigError(e.what());
    }
  });
}

}  // namespace
}  // namespace sprout::check

int main(int argc, char** argv) { return sprout::check::Main(argc, argv); }
