// Runs the graph for minutes and looks whether any process grows; scripts/soak says how to call it.
#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <map>
#include <thread>
#include <vector>

#include "common/app/process.h"
#include "tests/system/graph.h"
#include "tests/system/slope.h"

namespace sprout {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::seconds;

constexpr const char* kStages[] = {"refine", "prior", "grow", "depth"};

// Until then buffers and pools take their size: a quarter of the run, at most two minutes.
constexpr seconds kLongestWarmUp{120};

// What the resident memory may grow by over the whole run, as its slope has it: 2 MiB, and 1 % of
// it.
constexpr double kMaxGrowthBytes = 2 << 20;
constexpr double kMaxGrowthShare = 0.01;

struct Sample {
  double time_s;
  double rss_bytes;
  int64_t descriptors;
  int64_t threads;
};

int64_t EntriesOf(const std::string& folder) {
  return std::distance(std::filesystem::directory_iterator(folder), {});
}

Sample Look(pid_t pid, double time_s) {
  const std::string process = fmt::format("/proc/{}", pid);
  int64_t pages = 0;
  int64_t resident = 0;
  std::ifstream(process + "/statm") >> pages >> resident;
  return {.time_s = time_s,
          .rss_bytes = static_cast<double>(resident) * 4096,
          .descriptors = EntriesOf(process + "/fd"),
          .threads = EntriesOf(process + "/task")};
}

// Of a number that must not change.
struct Bounds {
  int64_t low;
  int64_t high;
};

Bounds BoundsOf(const std::vector<Sample>& samples, int64_t Sample::*number) {
  const auto [low, high] =
      std::minmax_element(samples.begin(), samples.end(),
                          [&](const Sample& a, const Sample& b) { return a.*number < b.*number; });
  return {(*low).*number, (*high).*number};
}

// Prints a line; false when something grows.
bool Judge(const std::string& name, const std::vector<Sample>& samples, double run_s) {
  std::vector<double> times_s;
  std::vector<double> rss_bytes;
  for (const Sample& sample : samples) {
    times_s.push_back(sample.time_s);
    rss_bytes.push_back(sample.rss_bytes);
  }
  const double growth = SlopeOf(times_s, rss_bytes) * run_s;
  const double most = kMaxGrowthBytes + kMaxGrowthShare * rss_bytes.back();
  const Bounds descriptors = BoundsOf(samples, &Sample::descriptors);
  const Bounds threads = BoundsOf(samples, &Sample::threads);
  const bool flat =
      growth <= most && descriptors.low == descriptors.high && threads.low == threads.high;
  std::cout << fmt::format("{:<8} {:>9.1f} {:>15.2f} {:>7.2f} {:>9}-{} {:>6}-{}  {}\n", name,
                           rss_bytes.back() / (1 << 20), growth / (1 << 20), most / (1 << 20),
                           descriptors.low, descriptors.high, threads.low, threads.high,
                           flat ? "flat" : "GROWS");
  return flat;
}

// Lockstep waits for grow's answers: depth, which comes behind them, may skip frames on a busy
// machine.
bool LosesNothing(Graph& graph) {
  bool nothing = true;
  graph.Look([&](Graph& g) {
    for (const auto& [name, s] : g.statuses) {
      const int64_t may_skip = name == "depth" ? s.frames_skipped : 0;
      const int64_t lost = s.frames_skipped + s.frames_incomplete + s.frames_failed +
                           s.frames_degenerate + s.frames_resent + s.bad_messages +
                           s.sequence_gaps - may_skip;
      std::cout << fmt::format("{:<8} {} frames answered, {} skipped, {} lost or sent again\n",
                               name, s.frames_out, s.frames_skipped, lost);
      nothing = nothing && lost == 0 && s.frames_out + may_skip == g.statuses["capture"].frames_out;
    }
  });
  return nothing;
}

int Run(double run_s) {
  Graph graph;
  for (const char* stage : kStages) graph.Start(stage, {"--config", "default"});
  graph.Start("capture", {"--source", "synthetic:160x120", "--rate", "20", "--lockstep", "1",
                          "--wait-for", "refine,prior,grow,depth", "--config", "default"});
  const double warm_up_s = std::min<double>(run_s / 4, static_cast<double>(kLongestWarmUp.count()));
  std::map<std::string, std::vector<Sample>> samples;
  const auto started = Clock::now();
  for (double time_s = 0; time_s < run_s;) {
    std::this_thread::sleep_for(seconds(1));
    time_s = std::chrono::duration<double>(Clock::now() - started).count();
    if (time_s < warm_up_s) continue;
    for (const char* name : {"capture", "refine", "prior", "grow", "depth"}) {
      Process& process = graph.process(name);
      if (process.Wait(seconds(0))) {
        std::cout << name << " has ended:\n" << process.Output();
        return 1;
      }
      samples[name].push_back(Look(process.pid(), time_s));
    }
  }
  graph.process("capture").Signal(SIGTERM);
  graph.process("capture").Wait();
  graph.WaitUntil(
      [](Graph& g) {
        const int64_t sent = g.statuses["capture"].frames_out;
        return g.statuses["capture"].state == StageStatus::State::kStopped &&
               std::all_of(std::begin(kStages), std::end(kStages), [&](const char* stage) {
                 return g.statuses[stage].newest_frame.seq == sent - 1;
               });
      },
      seconds(5));
  std::cout << fmt::format("{:<8} {:>9} {:>15} {:>7} {:>11} {:>8}\n", "process", "rss, MiB",
                           "slope, MiB/run", "at most", "descriptors", "threads");
  bool good = true;
  for (const auto& [name, taken] : samples) good = Judge(name, taken, run_s) && good;
  good = LosesNothing(graph) && good;
  std::cout << (good ? "nothing grows, nothing is lost\n" : "FAILED\n");
  return good ? 0 : 1;
}

}  // namespace
}  // namespace sprout

int main(int argc, char** argv) {
  if (argc != 2 || std::atof(argv[1]) <= 0) {
    std::cerr << "usage: soak MINUTES; scripts/soak gives it a network of its own\n";
    return 2;
  }
  return sprout::Run(std::atof(argv[1]) * 60);
}
