// Reads what sprout_bench measured, and prints and writes what it comes to: ratios first.
//   sprout_bench_summary TIMES.json GRAPH.json|- BASELINE.json|- SUMMARY.json
#include <fmt/core.h>

#include <algorithm>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

namespace {

using nlohmann::ordered_json;

ordered_json Read(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw std::runtime_error(path + ": cannot be read");
  return ordered_json::parse(file);
}

// PART/PRESET/MEGAPIXELS/THREADS/... of a benchmark's name.
struct Measured {
  std::string part, preset, megapixels, threads;
  double ms = 0;  // of one frame
  double cpu_ms = 0;
  double pixels = 0;
};

std::vector<Measured> ReadTimes(const std::string& path) {
  std::vector<Measured> all;
  const ordered_json times = Read(path);
  for (const auto& run : times.at("benchmarks")) {
    if (run.value("run_type", "") == "aggregate") continue;
    Measured one;
    std::istringstream name(run.at("name").get<std::string>());
    for (std::string* field : {&one.part, &one.preset, &one.megapixels, &one.threads}) {
      std::getline(name, *field, '/');
    }
    const double scenes = run.at("scenes");
    one.ms = run.at("real_time").get<double>() / scenes;
    one.cpu_ms = run.at("cpu_time").get<double>() / scenes;
    one.pixels = run.at("pixels");
    all.push_back(one);
  }
  return all;
}

const Measured* Find(const std::vector<Measured>& all, const std::string& part,
                     const std::string& preset, const Measured& like) {
  const auto found = std::find_if(all.begin(), all.end(), [&](const Measured& one) {
    return one.part == part && one.preset == preset && one.megapixels == like.megapixels &&
           one.threads == like.threads;
  });
  return found == all.end() ? nullptr : &*found;
}

// The whole chain and growth alone; with one thread by CPU time, which others on the machine
// disturb least.
ordered_json Summarise(const std::vector<Measured>& all) {
  ordered_json ratios, growth;
  for (const Measured& one : all) {
    const bool single = one.threads == "1";
    if (one.part == "grow") {
      const double ms = single ? one.cpu_ms : one.ms;
      growth[one.preset][one.megapixels][one.threads] = ms * 1e6 / one.pixels;
    }
    if (one.part != "chain") continue;
    const Measured* sgbm = Find(all, "sgbm-3way", "opencv", one);
    if (sgbm == nullptr) continue;
    ratios[one.preset][one.megapixels][one.threads] =
        single ? sgbm->cpu_ms / one.cpu_ms : sgbm->ms / one.ms;
  }
  return {{"chain_vs_sgbm_3way", ratios}, {"grow_ns_per_px", growth}};
}

void PrintSummary(const ordered_json& summary) {
  fmt::print("times faster than OpenCV's SGBM 3-way (256 disparities), whole chain\n");
  for (const auto& [preset, sizes] : summary.at("chain_vs_sgbm_3way").items()) {
    for (const auto& [megapixels, threads] : sizes.items()) {
      for (const auto& [count, ratio] : threads.items()) {
        fmt::print("  {:8} {:>5} MP, {} thread(s): {:5.2f}\n", preset, megapixels, count,
                   ratio.get<double>());
      }
    }
  }
  fmt::print("growth alone, ns a pixel\n");
  for (const auto& [preset, sizes] : summary.at("grow_ns_per_px").items()) {
    for (const auto& [megapixels, threads] : sizes.items()) {
      for (const auto& [count, ns] : threads.items()) {
        fmt::print("  {:8} {:>5} MP, {} thread(s): {:5.1f}\n", preset, megapixels, count,
                   ns.get<double>());
      }
    }
  }
}

// Frames that stages dropped: "refine 12, prior 3".
std::string DroppedText(const ordered_json& run) {
  std::string text;
  for (const auto& [stage, dropped] : run.at("dropped").items()) {
    const int64_t frames = dropped.at("skipped");
    if (frames > 0) text += fmt::format("{}{} {}", text.empty() ? "" : ", ", stage, frames);
  }
  return text.empty() ? "none" : text;
}

// A row a run.
void PrintGraph(const ordered_json& runs) {
  fmt::print("the running graph; ages of the answers, ms, and what they may be\n");
  fmt::print("{:8} {:9} {:>5} {:>5} {:>8} {:>8} {:>6} {:>6} {:>6} {:>6} {:>6} {:>9}  {:28} {}\n",
             "preset", "hosting", "Hz", "load", "captured", "answered", "p50", "p99", "max",
             "limit", "older", "CPU ms", "skipped", "CPU ms a frame of");
  for (const ordered_json& run : runs) {
    fmt::print(
        "{:8} {:9} {:5.1f} {:5} {:8} {:8} {:6.0f} {:6.0f} {:6.0f} {:6.0f} {:6} {:9.1f}  {:28} {}\n",
        run.at("preset").get<std::string>(), run.at("hosting").get<std::string>(),
        run.at("fps").get<double>(), run.at("load").get<int>(), run.at("captured").get<int64_t>(),
        run.at("answered").get<int64_t>(), run.at("age_p50_ms").get<double>(),
        run.at("age_p99_ms").get<double>(), run.at("age_max_ms").get<double>(),
        run.at("limit_p50_ms").get<double>(), run.at("older_than_limit").get<int64_t>(),
        run.at("cpu_ms_per_frame").get<double>(), DroppedText(run),
        run.at("cpu_ms_per_frame_of").dump());
  }
}

void PrintTimes(const std::vector<Measured>& all, const std::vector<Measured>& baseline) {
  fmt::print("{:10} {:8} {:>5} {:>7} {:>10} {:>10} {:>12}\n", "part", "preset", "MP", "threads",
             "ms", "CPU ms", "vs baseline");
  for (const Measured& one : all) {
    const Measured* before = Find(baseline, one.part, one.preset, one);
    const std::string change =
        before == nullptr ? "" : fmt::format("{:+.1f} %", (one.cpu_ms / before->cpu_ms - 1) * 100);
    fmt::print("{:10} {:8} {:>5} {:>7} {:10.2f} {:10.2f} {:>12}\n", one.part, one.preset,
               one.megapixels, one.threads, one.ms, one.cpu_ms, change);
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 5) {
    std::cerr << "usage: sprout_bench_summary TIMES GRAPH|- BASELINE|- SUMMARY\n";
    return 2;
  }
  try {
    const std::string graph = argv[2], baseline = argv[3];
    const std::vector<Measured> all = ReadTimes(argv[1]);
    ordered_json summary = Summarise(all);
    if (graph != "-") summary["graph"] = Read(graph);
    PrintSummary(summary);
    if (graph != "-") PrintGraph(summary["graph"]);
    PrintTimes(all, baseline == "-" ? std::vector<Measured>() : ReadTimes(baseline));
    std::ofstream(argv[4]) << summary.dump(2) << "\n";
    return 0;
  } catch (const std::exception& e) {
    std::cerr << "sprout_bench_summary: " << e.what() << "\n";
    return 1;
  }
}
