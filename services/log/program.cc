#include "services/log/program.h"

#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <functional>
#include <iostream>
#include <string>
#include <vector>

#include "common/app/program.h"
#include "common/app/version.h"
#include "common/config/config_error.h"
#include "common/logfile/log_error.h"
#include "common/quality/frame_quality.h"
#include "services/log/commands.h"
#include "services/log/read_progress.h"

namespace sprout::log {
namespace {

constexpr char kDescription[] =
    "Inspects, compares, ranks, cuts, repairs and exports logs of sprout-record, lcm-logger or "
    "a\nreplay. Logs may be larger than memory, and damaged: every good event is found.";

constexpr char kFooter[] = R"(
Examples
  sprout-log info run.lcm                                    what is in it, is it damaged
  sprout-log rank run.lcm                                    where are the bad frames
  sprout-log diff run.lcm new.lcm --channels SPROUT_SEEDS    did my change change anything
  sprout-log cut run.lcm one.lcm --frames 40:50              the interesting frames
  sprout-log images one.lcm pictures                         look at them
  sprout-log export --mcap one.mcap one.lcm                  show them to Foxglove, RViz, rerun

`sprout-log COMMAND --help` explains a command. Exit codes: 0; 1 different, or info --check found
something; 2 a flag or a log that cannot be used. Output logs are renamed into place when complete.
)";

using Command = std::function<int()>;

struct Commands {
  InfoOptions info;
  DiffOptions diff;
  CutOptions cut;
  MergeOptions merge;
  RepairOptions repair;
  ImagesOptions images;
  ExportOptions export_;
  std::string mcap;         // of export
  bool force_mcap = false;  // of export
  RankOptions rank;
  Command chosen;
};

void AddPrefix(CLI::App& flags, std::string& prefix) {
  flags.add_option("--channel-prefix", prefix, "Prefix of the channels, as given to the services")
      ->type_name("TEXT");
}

CLI::Option* AddFrames(CLI::App& flags, std::string& frames) {
  return flags
      .add_option("--frames", frames,
                  "Frames by number (header.seq), both ends included; A:, :B and A work as well")
      ->type_name("A:B");
}

void AddChannels(CLI::App& flags, std::vector<std::string>& channels) {
  flags
      .add_option("--channels", channels, "Only these (without prefix); may be given several times")
      ->type_name("NAME,NAME,...")
      ->delimiter(',')
      ->expected(1)
      ->take_all();
}

void AddForce(CLI::App& flags, bool& force) {
  flags.add_flag("--force", force, "Overwrite OUT if it exists");
}

void AddInfo(CLI::App& program, Commands& commands) {
  CLI::App& flags = *program.add_subcommand(
      "info",
      "Prints for each channel type, messages, rate, times, frames, and how many frame numbers "
      "are\nmissing, repeated or undecodable; and where the file is damaged");
  InfoOptions& options = commands.info;
  flags.add_option("FILE", options.file, "Log, or MCAP file")->required();
  AddPrefix(flags, options.prefix);
  flags.add_flag("--json", options.json, "For programs; has the configurations, too");
  flags.add_flag("--config", options.config, "Also the effective configuration of each process");
  flags.add_flag(
      "--check", options.check,
      "Exit code 1 when something is damaged or undecodable, or frame numbers are missing");
  flags.callback([&] { commands.chosen = [&] { return RunInfo(commands.info); }; });
}

void AddDiff(CLI::App& program, Commands& commands) {
  CLI::App& flags = *program.add_subcommand(
      "diff",
      "Compares two logs frame by frame: messages are matched by channel and header\n"
      "(utime, seq). Exit code 0 equal, 1 different, 2 unusable");
  flags.footer(R"(
Messages with the same bytes are equal; so are messages that decode to the same values, such as a
map sent raw and compressed, with a remark. Calibrations are matched by rig_id. A message repeated
with the same bytes counts once. Statuses, which depend on clock and machine, SPROUT_PROCESS and
LCM's own channels are compared only when named by --channels; configurations that differ are shown, but are no difference of the answers.)");
  DiffOptions& options = commands.diff;
  flags.add_option("A", options.a, "Log, such as a recorded one")->required();
  flags.add_option("B", options.b, "Log, such as a replayed one")->required();
  AddChannels(flags, options.channels);
  AddPrefix(flags, options.prefix);
  flags.add_flag(
      "--common", options.common,
      "Messages in only one log are no difference: a live run skips frames that a replay does not");
  flags.add_flag("--all", options.all, "A line for every frame, also for equal ones");
  flags
      .add_option(
          "--images", options.images,
          "Write pictures of A, B and their difference, of the maps and images that differ; "
          "without --all of the first 10")
      ->type_name("DIR");
  flags.callback([&] { commands.chosen = [&] { return RunDiff(commands.diff); }; });
}

void AddCut(CLI::App& program, Commands& commands) {
  CLI::App& flags = *program.add_subcommand(
      "cut",
      "Writes some frames or channels of a log to a new one. Calibrations (RIG) of the frames "
      "are\nalways kept, and with --frames also SPROUT_PROCESS, once for each process; other "
      "messages\nwithout a frame are kept only without --frames");
  CutOptions& options = commands.cut;
  flags.add_option("IN", options.in, "Log")->required();
  flags.add_option("OUT", options.out, "New log")->required();
  CLI::Option* frames = AddFrames(flags, options.frames);
  flags
      .add_option("--warm-up", options.warm_up,
                  "Also keep so many frames before those of --frames: for a replay of "
                  "sprout-temporal, which remembers earlier frames")
      ->type_name("N")
      ->check(CLI::Range(int64_t{0}, int64_t{1'000'000}))
      ->capture_default_str()
      ->needs(frames);
  AddChannels(flags, options.channels);
  AddPrefix(flags, options.prefix);
  AddForce(flags, options.force);
  flags.callback([&] { commands.chosen = [&] { return RunCut(commands.cut); }; });
}

void AddMerge(CLI::App& program, Commands& commands) {
  CLI::App& flags =
      *program.add_subcommand("merge", "Merges logs into one, by the time of their events");
  MergeOptions& options = commands.merge;
  flags.add_option("IN", options.in, "Logs; of equal times, the log named first comes first")
      ->required();
  flags.add_option("--out", options.out, "New log")->required()->type_name("OUT");
  AddForce(flags, options.force);
  flags.callback([&] { commands.chosen = [&] { return RunMerge(commands.merge); }; });
}

void AddRepair(CLI::App& program, Commands& commands) {
  CLI::App& flags = *program.add_subcommand(
      "repair",
      "Writes all good events of a damaged log to a new one that every LCM tool reads, and\nprints "
      "what was lost. Undecodable messages are kept: a later program may understand them");
  RepairOptions& options = commands.repair;
  flags.add_option("IN", options.in, "Log")->required();
  flags.add_option("OUT", options.out, "New log")->required();
  flags.add_flag("--drop-undecodable", options.drop_undecodable,
                 "Drop messages that services would refuse");
  AddForce(flags, options.force);
  flags.callback([&] { commands.chosen = [&] { return RunRepair(commands.repair); }; });
}

void AddImages(CLI::App& program, Commands& commands) {
  CLI::App& flags = *program.add_subcommand(
      "images",
      "Writes left and right image, ToF depth, seeds, prior, disparity, the cloud from the side "
      "and\n"
      "an overview of each frame as PNG, as far as the log has them; colours of a frame share one\n"
      "scale. Prints how many seeds and pixels there are");
  ImagesOptions& options = commands.images;
  flags.add_option("FILE", options.file, "Log")->required();
  flags.add_option("DIR", options.folder, "Folder to write to: 000042_left.png, ...")->required();
  flags
      .add_option(
          "--truth", options.truth,
          "The source that capture sent, for its ground truth: a picture of the errors, and "
          "the share of correct pixels")
      ->type_name("SOURCE");
  AddFrames(flags, options.frames);
  AddPrefix(flags, options.prefix);
  flags.callback([&] { commands.chosen = [&] { return RunImages(commands.images); }; });
}

int RunEitherExport(const Commands& commands) {
  const ExportOptions& options = commands.export_;
  if (commands.mcap.empty()) return RunExport(options);
  return RunMcapExport({.file = options.file,
                        .out = commands.mcap,
                        .frames = options.frames,
                        .prefix = options.prefix,
                        .force = commands.force_mcap});
}

void AddExport(CLI::App& program, Commands& commands) {
  CLI::App& flags = *program.add_subcommand("export",
                                            "Writes each frame for other programs, or with --mcap "
                                            "all of a log as ROS 2's messages");
  ExportOptions& options = commands.export_;
  flags.add_option("FILE", options.file, "Log")->required();
  CLI::Option* folder =
      flags.add_option("DIR", options.folder, "Folder to write to: 000042_disparity.pfm, ...");
  flags.add_flag("--ply", options.ply,
                 "Coloured point cloud of the disparity map, m in the left rectified frame");
  flags.add_flag("--mesh", options.mesh,
                 "Coloured surface of the disparity map, cut at depth edges, m");
  flags.add_flag("--pfm", options.pfm,
                 "Prior and disparity maps, px; +inf: no disparity; sigma, px");
  CLI::Option* mcap =
      flags
          .add_option("--mcap", commands.mcap,
                      "One MCAP file for rosbag2, Foxglove and rerun: the images, depth, points, "
                      "disparities and statuses of the log on the topics of sprout-ros2")
          ->type_name("OUT")
          ->excludes(folder);
  AddForce(flags, commands.force_mcap);
  AddFrames(flags, options.frames);
  AddPrefix(flags, options.prefix);
  flags.callback([&commands, folder, mcap] {
    if (mcap->empty() && folder->empty()) throw CLI::RequiredError("DIR");
    commands.chosen = [&commands] { return RunEitherExport(commands); };
  });
}

void AddRank(CLI::App& program, Commands& commands) {
  CLI::App& flags =
      *program.add_subcommand("rank",
                              "Lists the frames of a log, the worst first, by figures that need no "
                              "ground truth. The log must\nhave the images and the answers: "
                              "`sprout-log merge` combines a recording and a replay");
  RankOptions& options = commands.rank;
  flags.add_option("LOG", options.file, "Log")->required();
  flags
      .add_option("--top", options.top,
                  "Only the N worst frames. Without it the table and --images have 20, --csv and "
                  "--json all of the log")
      ->check(CLI::Range(1, 1'000'000))
      ->type_name("N");
  flags.add_option("--by", options.by, "What to rank by, a column below")
      ->type_name("COLUMN")
      ->capture_default_str();
  CLI::Option* csv = flags.add_flag("--csv", options.csv, "For spreadsheets, all digits");
  flags.add_flag("--json", options.json, "For programs, all digits")->excludes(csv);
  flags.add_option("--images", options.folder, "Write the pictures of the worst frames")
      ->type_name("DIR");
  AddFrames(flags, options.frames);
  AddPrefix(flags, options.prefix);
  std::string columns = "Columns\n";
  for (const QualityColumn& column : QualityColumns()) {
    columns += fmt::format("  {:<14}{}\n", column.name, column.meaning);
  }
  flags.footer(columns);
  flags.callback([&] { commands.chosen = [&] { return RunRank(commands.rank); }; });
}

int RunChosen(const Command& command) {
  try {
    return command();
  } catch (const LogError& e) {
    throw ConfigError(e.what());  // exit code 2
  } catch (const Interrupted&) {
    std::cerr << "sprout-log: interrupted\n";
    return 130;
  }
}

}  // namespace

int LogMain(int argc, const char* const* argv) {
  CLI::App flags(kDescription, "sprout-log");
  Commands commands;
  flags.require_subcommand(1);
  AddInfo(flags, commands);
  AddDiff(flags, commands);
  AddCut(flags, commands);
  AddMerge(flags, commands);
  AddRepair(flags, commands);
  AddImages(flags, commands);
  AddExport(flags, commands);
  AddRank(flags, commands);
  flags.set_version_flag("--version", "sprout-log " + Version());
  flags.footer(kFooter);
  return RunProgram(flags, argc, argv, [&] { return RunChosen(commands.chosen); });
}

}  // namespace sprout::log
