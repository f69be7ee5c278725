#include "services/tools/batch/program.h"

#include <iostream>

#include "common/app/compute.h"
#include "common/app/program.h"
#include "common/app/version.h"
#include "common/core/interrupt.h"
#include "common/logfile/log_error.h"
#include "services/tools/batch/commands.h"

namespace sprout::batch {
namespace {

constexpr char kDescription[] =
    "Replays stages on many logs, on all cores or with Slurm, compares two configurations or\n"
    "two builds frame by frame, and writes a table and a report.";

constexpr char kFooter[] = R"(
Examples
  sprout-batch run logs/ --out out/fast --config fast           one configuration
  sprout-batch run logs/ --out out/ab --config default --config-b default --config-b try.textproto
  sprout-batch run logs/ --out out/new --programs-b ../new/build/release/bin     two builds
  sprout-batch run @list.txt --out /shared/ab --engine slurm --partition short   on a cluster
  sprout-batch status /shared/ab

Repeating a command computes only what is missing. `sprout-batch COMMAND --help` explains
a command. Exit codes: 0; 1 something is missing; 2 a flag or log that cannot be used; 130 Ctrl-C.
)";

void AddSlurm(Flags& flags, SlurmOptions& slurm) {
  flags.Add("--partition", slurm.partition, "Slurm: partition (default: the cluster's)");
  flags.Add("--memory", slurm.memory, "Slurm: memory of a task").ShowDefault();
  flags.Add("--time", slurm.time, "Slurm: longest time of a task").ShowDefault();
  flags.Add("--array-size", slurm.array_size, "Slurm: most tasks of the job array")
      .WithinWhole(1, 4'000'000)
      .ShowDefault();
}

void AddRun(Flags& program, Options& options) {
  Flags& flags = program.AddCommand(
      "run", "Computes the missing results of a batch, or all of a new one, then table and report",
      [&options] { return RunRun(options); });
  BatchRequest& request = options.request;
  flags
      .Add("LOG", request.inputs,
           "Logs, folders of logs (*.lcm), or @LIST: a file with one of these a line")
      .Required();
  flags.Add("--out", request.out, "Folder of the batch; results are kept in it").Required();
  flags.Add("--stages", request.stages, "Stages to run, of refine,prior,grow,temporal")
      .Repeatable()
      .SplitAtCommas()
      .ShowDefault();
  flags.Add("--keep", request.keep, "Stages whose answers are kept, beside the last one's")
      .Repeatable()
      .SplitAtCommas();
  flags
      .Add("--config FILE|PRESET", request.config_a,
           "Configuration A, as for the services; several are merged")
      .Repeatable();
  flags.Add("--config-b FILE|PRESET", request.config_b, "Configuration B, to compare with A")
      .Repeatable();
  flags.Add("--programs-a", request.programs_a,
            "Folder of the stages' programs (default: that of sprout-batch)");
  flags.Add("--programs-b", request.programs_b, "Those of B, to compare with another build");
  flags.Add("--truth", request.truth,
            "Folder with LOGNAME/NNNNNN_disparity.pfm, true disparities of frames");
  flags.Add("--no-measures", request.no_measures,
            "Do not measure the frames: no score and no other figures of quality in the table");
  flags.Add("--channel-prefix", request.prefix, "Prefix of every channel of the logs");
  flags.Add("--engine", options.engine, "Where to compute").OneOf({"local", "slurm"}).ShowDefault();
  flags.Add("--jobs", options.local.jobs, "local: logs at a time, 0 = one a core")
      .WithinWhole(0, 4096)
      .ShowDefault();
  flags.Add("--retries", options.local.retries, "How often a failed log is tried again")
      .WithinWhole(0, 100)
      .ShowDefault();
  AddSlurm(flags, options.slurm);
}

void AddOthers(Flags& program, Options& options) {
  const auto add = [&](const char* name, const char* text, int (*run)(const Options&)) -> Flags& {
    Flags& flags = program.AddCommand(name, text, [&options, run] { return run(options); });
    flags.Add("OUT", options.out, "Folder of the batch").Required();
    return flags;
  };
  add("status", "Progress of a batch", RunStatus);
  add("report", "Writes table and report of the finished logs", RunReport);
  Flags& compute = add("compute", "Computes logs; called by both engines", RunCompute);
  compute.Add("LOG", options.logs, "Numbers of logs").Required();
  compute.Add("--threads", options.threads, "Threads of a stage")
      .WithinWhole(1, kMaxThreads)
      .ShowDefault();
  Flags& finish =
      add("finish", "Slurm's last job: as report, and submits missing logs again", RunFinish);
  finish.Add("--round", options.round, "Number of the submission").ShowDefault();
  finish.Add("--retries", options.slurm.retries, "Most rounds").ShowDefault();
  AddSlurm(finish, options.slurm);
}

}  // namespace

int BatchMain(int argc, const char* const* argv) {
  Flags program("sprout-batch", kDescription);
  program.SetFooter(kFooter);
  program.AddVersion(Version());
  program.RequireCommand();
  Options options;
  AddRun(program, options);
  AddOthers(program, options);
  return RunProgram(program, argc, argv, [&] {
    try {
      return program.RunCommand();
    } catch (const Interrupted& e) {
      std::cerr << "sprout-batch: " << e.what() << "; the same command continues from here\n";
      return 130;
    } catch (const LogError& e) {
      throw ConfigError(e.what());
    }
  });
}

}  // namespace sprout::batch
