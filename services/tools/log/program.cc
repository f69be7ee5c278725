#include "services/tools/log/program.h"

#include <exception>
#include <iostream>

#include "common/app/program.h"
#include "common/config/config_error.h"
#include "common/core/signal_watcher.h"
#include "services/tools/log/commands.h"

namespace sprout::log {
namespace {

constexpr char kDescription[] =
    "Inspects, compares, ranks, cuts, repairs, compresses and exports logs of sprout-record,\n"
    "lcm-logger or a replay. Logs may be larger than memory, and damaged: every good event is "
    "found.";

constexpr char kFooter[] = R"(
Examples
  sprout-log info run.lcm                                    what is in it, is it damaged
  sprout-log rank run.lcm                                    where are the bad frames
  sprout-log diff run.lcm new.lcm --channels SPROUT_SEEDS    did my change change anything
  sprout-log cut run.lcm one.lcm --frames 40:50              the interesting frames
  sprout-log compress run.lcm small.lcm                      the same in about half the bytes
  sprout-log merge run.lcm new.lcm --out all.lcm --replace   new answers in the place of old ones
  sprout-log images one.lcm pictures                         look at them
  sprout-log export --mcap one.mcap one.lcm                  show them to Foxglove, RViz, rerun

`sprout-log COMMAND --help` explains a command. Exit codes: 0; 1 different, or info --check found
something; 2 a flag or a log that cannot be used. Output logs are renamed into place when complete.
)";

int RunChosen(const Flags& flags) {
  try {
    return flags.RunCommand();
  } catch (const Interrupted&) {
    std::cerr << "sprout-log: interrupted\n";
    return 130;
  } catch (const std::exception& e) {  // exit code 2, since 1 says that logs differ
    throw ConfigError(e.what() + ReachedLimitText(e));
  }
}

}  // namespace

void AddPrefix(Flags& flags, std::string& prefix) {
  flags.Add("--channel-prefix TEXT", prefix, "Prefix of the channels, as given to the services");
}

Flag AddFrames(Flags& flags, std::string& frames) {
  return flags.Add("--frames A:B", frames,
                   "Frames by number (header.seq), both ends included; A:, :B and A work as well");
}

void AddChannels(Flags& flags, std::vector<std::string>& channels) {
  flags
      .Add("--channels NAME,NAME,...", channels,
           "Only these (without prefix); may be given several times")
      .SplitAtCommas()
      .Repeatable();
}

void AddForce(Flags& flags, bool& force) {
  flags.Add("--force", force, "Overwrite OUT if it exists");
}

int LogMain(int argc, const char* const* argv) {
  Flags flags("sprout-log", kDescription);
  flags.RequireCommand();
  AddInfo(flags);
  AddDiff(flags);
  AddCut(flags);
  AddMerge(flags);
  AddRepair(flags);
  AddCompress(flags);
  AddExpand(flags);
  AddImages(flags);
  AddExport(flags);
  AddRank(flags);
  flags.SetFooter(kFooter);
  const int exit_code = RunProgram(flags, argc, argv, [&] { return RunChosen(flags); });
  return std::cout ? exit_code : 2;  // a full disk, say
}

}  // namespace sprout::log
