#include "services/tools/log/program.h"

#include <fmt/core.h>

#include <iostream>
#include <string>
#include <vector>

#include "common/app/program.h"
#include "common/app/version.h"
#include "common/config/config_error.h"
#include "common/core/signal_watcher.h"
#include "common/logfile/log_error.h"
#include "common/measure/frame_quality.h"
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

struct Commands {
  InfoOptions info;
  DiffOptions diff;
  CutOptions cut;
  MergeOptions merge;
  RepairOptions repair;
  CompressOptions compress;
  ExpandOptions expand;
  ImagesOptions images;
  ExportOptions export_;
  std::string mcap;         // of export
  bool force_mcap = false;  // of export
  RankOptions rank;
};

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

void AddInfo(Flags& program, Commands& commands) {
  Flags& flags = program.AddCommand(
      "info",
      "Prints for each channel type, messages, rate, times, frames, and how many frame numbers "
      "are\nmissing, repeated or undecodable; and where the file is damaged",
      [&commands] { return RunInfo(commands.info); });
  InfoOptions& options = commands.info;
  flags.Add("FILE", options.file, "Log, or MCAP file").Required();
  AddPrefix(flags, options.prefix);
  flags.Add("--json", options.json, "For programs; has the configurations, too");
  flags.Add("--config", options.config, "Also the effective configuration of each process");
  flags.Add("--check", options.check,
            "Exit code 1 when something is damaged or undecodable, or frame numbers are missing");
}

void AddDiff(Flags& program, Commands& commands) {
  Flags& flags = program.AddCommand(
      "diff",
      "Compares two logs frame by frame: messages are matched by channel and header\n"
      "(utime, seq). Exit code 0 equal, 1 different, 2 unusable",
      [&commands] { return RunDiff(commands.diff); });
  flags.SetFooter(R"(
Messages with the same bytes are equal; so are messages that decode to the same values, such as a
map sent raw and compressed, with a remark. Calibrations are matched by rig_id. A message repeated
with the same bytes counts once. Statuses, which depend on clock and machine, SPROUT_PROCESS and
LCM's own channels are compared only when named by --channels; configurations that differ are shown, but are no difference of the answers.)");
  DiffOptions& options = commands.diff;
  flags.Add("A", options.a, "Log, such as a recorded one").Required();
  flags.Add("B", options.b, "Log, such as a replayed one").Required();
  AddChannels(flags, options.channels);
  AddPrefix(flags, options.prefix);
  flags.Add(
      "--common", options.common,
      "Messages in only one log are no difference: a live run skips frames that a replay does not");
  flags.Add("--all", options.all, "A line for every frame, also for equal ones");
  flags.Add("--images DIR", options.images,
            "Write pictures of A, B and their difference, of the maps and images that differ; "
            "without --all of the first 10");
}

void AddCut(Flags& program, Commands& commands) {
  Flags& flags = program.AddCommand(
      "cut",
      "Writes some frames or channels of a log to a new one. Calibrations (RIG) of the frames "
      "are\nalways kept, and with --frames also SPROUT_PROCESS, once for each process; other "
      "messages\nwithout a frame are kept only without --frames",
      [&commands] { return RunCut(commands.cut); });
  CutOptions& options = commands.cut;
  flags.Add("IN", options.in, "Log").Required();
  flags.Add("OUT", options.out, "New log").Required();
  Flag frames = AddFrames(flags, options.frames);
  flags
      .Add("--warm-up N", options.warm_up,
           "Also keep so many frames before those of --frames: for a replay of "
           "sprout-temporal, which remembers earlier frames")
      .WithinWhole(int64_t{0}, int64_t{1'000'000})
      .ShowDefault()
      .Needs(frames);
  AddChannels(flags, options.channels);
  AddPrefix(flags, options.prefix);
  AddForce(flags, options.force);
}

void AddMerge(Flags& program, Commands& commands) {
  Flags& flags = program.AddCommand(
      "merge",
      "Merges logs into one, by the time of their events. Logs that have different messages for "
      "one\nframe, such as a recording and the replay of one of its stages, need --replace",
      [&commands] { return RunMerge(commands.merge); });
  MergeOptions& options = commands.merge;
  flags.Add("IN", options.in, "Logs; of equal times, the log named first comes first").Required();
  flags.Add("--out OUT", options.out, "New log").Required();
  flags.Add("--replace", options.replace,
            "Take a channel from the last log that has it, as --replay does: later answers replace "
            "earlier ones. Of statuses and SPROUT_PROCESS all are kept");
  AddForce(flags, options.force);
}

void AddRepair(Flags& program, Commands& commands) {
  Flags& flags = program.AddCommand(
      "repair",
      "Writes all good events of a damaged log to a new one that every LCM tool reads, and\nprints "
      "what was lost. Undecodable messages are kept: a later program may understand them",
      [&commands] { return RunRepair(commands.repair); });
  RepairOptions& options = commands.repair;
  flags.Add("IN", options.in, "Log").Required();
  flags.Add("OUT", options.out, "New log").Required();
  flags.Add("--drop-undecodable", options.drop_undecodable,
            "Drop messages that services would refuse");
  AddForce(flags, options.force);
}

void AddCompress(Flags& program, Commands& commands) {
  Flags& flags = program.AddCommand(
      "compress",
      "Writes a log in fewer bytes: images lose nothing and take half, more or less. Every "
      "program\nof Sprout reads it as the original; `sprout-log expand` gives that back to the "
      "byte",
      [&commands] { return RunCompress(commands.compress); });
  CompressOptions& options = commands.compress;
  flags.Add("IN", options.in, "Log").Required();
  flags.Add("OUT", options.out, "New log").Required();
  flags
      .Add("--jpeg QUALITY", options.jpeg_quality,
           "Left and right images as JPEG of this quality: a tenth of the bytes, but what is lost "
           "does not come back, and replays differ")
      .WithinWhole(1, 100);
  AddForce(flags, options.force);
}

void AddExpand(Flags& program, Commands& commands) {
  Flags& flags = program.AddCommand(
      "expand", "Writes the log that was compressed, to the byte; for programs of others",
      [&commands] { return RunExpand(commands.expand); });
  ExpandOptions& options = commands.expand;
  flags.Add("IN", options.in, "Log, compressed or recorded with --compress").Required();
  flags.Add("OUT", options.out, "New log").Required();
  AddForce(flags, options.force);
}

void AddImages(Flags& program, Commands& commands) {
  Flags& flags = program.AddCommand(
      "images",
      "Writes left and right image, ToF depth, seeds, prior, disparity, the cloud from the side "
      "and\n"
      "an overview of each frame as PNG, as far as the log has them; colours of a frame share one\n"
      "scale. Prints how many seeds and pixels there are",
      [&commands] { return RunImages(commands.images); });
  ImagesOptions& options = commands.images;
  flags.Add("FILE", options.file, "Log").Required();
  flags.Add("DIR", options.folder, "Folder to write to: 000042_left.png, ...").Required();
  flags.Add("--truth SOURCE", options.truth,
            "The source that capture sent, for its ground truth: a picture of the errors, and "
            "the share of correct pixels");
  AddFrames(flags, options.frames);
  AddPrefix(flags, options.prefix);
}

int RunEitherExport(const Commands& commands) {
  const ExportOptions& options = commands.export_;
  if (commands.mcap.empty() && options.folder.empty()) {
    throw ConfigError("DIR is required (--help lists the flags)");
  }
  if (commands.mcap.empty()) return RunExport(options);
  return RunMcapExport({.file = options.file,
                        .out = commands.mcap,
                        .frames = options.frames,
                        .prefix = options.prefix,
                        .force = commands.force_mcap});
}

void AddExport(Flags& program, Commands& commands) {
  Flags& flags = program.AddCommand("export",
                                    "Writes each frame for other programs, or with --mcap "
                                    "all of a log as ROS 2's messages",
                                    [&commands] { return RunEitherExport(commands); });
  ExportOptions& options = commands.export_;
  flags.Add("FILE", options.file, "Log").Required();
  const Flag folder =
      flags.Add("DIR", options.folder, "Folder to write to: 000042_disparity.pfm, ...");
  flags.Add("--ply", options.ply,
            "Coloured point cloud of the disparity map, m in the left rectified frame, each point "
            "with its confidence if the log has it");
  flags.Add("--mesh", options.mesh, "Coloured surface of the disparity map, cut at depth edges, m");
  flags.Add("--pfm", options.pfm, "Prior and disparity maps, px; +inf: no disparity; sigma, px");
  flags.Add("--depth", options.depth,
            "Depth as PNG of 16 bits, mm, 0: none or more than 65.535 m; and intrinsics.json");
  flags.Add(
      "--npz", options.npz,
      "For NumPy: depth_m (m, NaN: none), disparity_px, confidence (0 to 255), K, utime, seq");
  flags
      .Add("--mcap OUT", commands.mcap,
           "One MCAP file for rosbag2, Foxglove and rerun: the images, depth, points, "
           "disparities and statuses of the log on the topics of sprout-ros2")
      .Excludes(folder);
  AddForce(flags, commands.force_mcap);
  AddFrames(flags, options.frames);
  AddPrefix(flags, options.prefix);
}

void AddRank(Flags& program, Commands& commands) {
  Flags& flags =
      program.AddCommand("rank",
                         "Lists the frames of a log, the worst first, by figures that need no "
                         "ground truth. The log must\nhave the images and the answers: "
                         "`sprout-log merge` combines a recording and a replay",
                         [&commands] { return RunRank(commands.rank); });
  RankOptions& options = commands.rank;
  flags.Add("LOG", options.file, "Log").Required();
  flags
      .Add("--top N", options.top,
           "Only the N worst frames. Without it the table and --images have 20, --csv and "
           "--json all of the log")
      .WithinWhole(1, 1'000'000);
  flags.Add("--by COLUMN", options.by, "What to rank by, a column below").ShowDefault();
  Flag csv = flags.Add("--csv", options.csv, "For spreadsheets, all digits");
  flags.Add("--json", options.json, "For programs, all digits").Excludes(csv);
  flags.Add("--images DIR", options.folder, "Write the pictures of the worst frames");
  AddFrames(flags, options.frames);
  AddPrefix(flags, options.prefix);
  std::string columns = "Columns\n";
  for (const QualityColumn& column : QualityColumns()) {
    columns += fmt::format("  {:<14}{}\n", column.name, column.meaning);
  }
  flags.SetFooter(columns);
}

int RunChosen(const Flags& flags) {
  try {
    return flags.RunCommand();
  } catch (const LogError& e) {
    throw ConfigError(e.what());  // exit code 2
  } catch (const Interrupted&) {
    std::cerr << "sprout-log: interrupted\n";
    return 130;
  }
}

}  // namespace

int LogMain(int argc, const char* const* argv) {
  Flags flags("sprout-log", kDescription);
  Commands commands;
  flags.RequireCommand();
  AddInfo(flags, commands);
  AddDiff(flags, commands);
  AddCut(flags, commands);
  AddMerge(flags, commands);
  AddRepair(flags, commands);
  AddCompress(flags, commands);
  AddExpand(flags, commands);
  AddImages(flags, commands);
  AddExport(flags, commands);
  AddRank(flags, commands);
  flags.AddVersion(Version());
  flags.SetFooter(kFooter);
  return RunProgram(flags, argc, argv, [&] { return RunChosen(flags); });
}

}  // namespace sprout::log
