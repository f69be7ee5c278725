// The graph over udpm at one rate: what got lost, how old the answers are, what it costs.
//   sprout_bench_graph PRESET stages|pipeline WxH RATE_HZ SECONDS FOLDER [LOAD]
// stages: refine, prior and grow are processes of their own; pipeline: sprout-pipeline is all
// three. The frame is a Middlebury scene of SPROUT_DATA in that size, written to FOLDER, over and
// over. Beside it so many other processes compute all the time (LOAD, default 0). Prints one line
// of JSON. Exit code 0 when every frame was answered, 3 when one was not.
#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <deque>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <limits>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <sstream>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "common/app/process.h"
#include "common/bus/channels.h"
#include "common/bus/lcm_url.h"
#include "common/bus/receiver.h"
#include "common/messages/codec.h"
#include "tests/bench/bench_frame.h"

namespace sprout {
namespace {

namespace fs = std::filesystem;

double Quantile(std::vector<double> values, double share) {
  if (values.empty()) return std::nan("");
  std::ranges::sort(values);
  const auto rank = static_cast<size_t>(std::ceil(share * static_cast<double>(values.size())));
  return values[std::max<size_t>(rank, 1) - 1];
}

// What processes log about each frame with --log-level debug.
class FrameTimes {
 public:
  // @param log  what the process of a stage wrote.
  void Read(const std::string& stage, std::string_view log);

  // Ages of the answers (capture to answer published), and what they may be: twice what all stages
  // worked on a frame, on average over the answers of the second before, and the time between two
  // frames.
  // @param stages  in their order; the last one answers.
  nlohmann::ordered_json Summarise(const std::vector<std::string>& stages, double rate_hz) const;

 private:
  struct Times {
    double waited_ms = 0;  // behind other frames
    double worked_ms = 0;
    double age_ms = 0;
  };
  std::map<std::string, std::map<int64_t, Times>> times_;  // by stage and number of the frame
};

void FrameTimes::Read(const std::string& stage, std::string_view log) {
  std::istringstream lines{std::string(log)};
  std::map<int64_t, Times>& frames = times_[stage];
  for (std::string line; std::getline(lines, line);) {
    const size_t start = line.find("frame ");
    if (start == std::string::npos) continue;
    const char* text = line.c_str() + start;
    long long seq = 0;
    double ms = 0;
    double age_ms = 0;
    if (std::sscanf(text, "frame %lld: waited %lf ms", &seq, &ms) == 2) {
      frames[seq].waited_ms = ms;
    } else if (std::sscanf(text, "frame %lld: %lf ms, age %lf ms", &seq, &ms, &age_ms) == 3) {
      // Of sprout-pipeline the steps come first, then all of it.
      frames[seq].worked_ms = ms - frames[seq].waited_ms;
      frames[seq].age_ms = age_ms;
    }
  }
  std::erase_if(frames, [](const auto& frame) { return frame.second.age_ms == 0; });
}

nlohmann::ordered_json FrameTimes::Summarise(const std::vector<std::string>& stages,
                                             double rate_hz) const {
  struct Recent {
    double answered_ms;
    double worked_ms;
  };
  nlohmann::ordered_json result;
  const auto answering = times_.find(stages.back());
  if (answering == times_.end()) return result;
  const double interval_ms = 1000 / rate_hz;
  std::deque<Recent> recent;
  std::vector<double> ages, limits;
  double worst = 0;
  int64_t too_old = 0;
  for (const auto& [seq, answer] : answering->second) {
    double worked_ms = 0;
    for (const std::string& stage : stages) {
      const auto& of_stage = times_.at(stage);
      const auto it = of_stage.find(seq);
      if (it == of_stage.end()) continue;
      worked_ms += it->second.worked_ms;
    }
    const double now_ms = static_cast<double>(seq) * interval_ms + answer.age_ms;
    recent.push_back({now_ms, worked_ms});
    while (recent.front().answered_ms < now_ms - 1000) recent.pop_front();
    double sum_ms = 0;
    for (const Recent& one : recent) sum_ms += one.worked_ms;
    const double limit_ms = 2 * sum_ms / static_cast<double>(recent.size()) + interval_ms;
    ages.push_back(answer.age_ms);
    limits.push_back(limit_ms);
    worst = std::max(worst, answer.age_ms / limit_ms);
    if (answer.age_ms > limit_ms) ++too_old;
  }
  result["age_p50_ms"] = Quantile(ages, 0.5);
  result["age_p99_ms"] = Quantile(ages, 0.99);
  result["age_max_ms"] = Quantile(ages, 1);
  result["limit_p50_ms"] = Quantile(limits, 0.5);
  result["older_than_limit"] = too_old;
  result["worst_age_to_limit"] = worst;
  return result;
}

// The processes beside sprout-capture; the last one answers with the disparity.
using Stages = std::vector<std::string>;

Stages StagesOf(const std::string& hosting) {
  return hosting == "pipeline" ? Stages{"pipeline"} : Stages{"refine", "prior", "grow"};
}

// CPU time of a process so far, ms: fields 14 and 15 of its stat, counted behind its name.
double CpuMs(int pid) {
  std::ifstream file("/proc/" + std::to_string(pid) + "/stat");
  std::string text;
  std::getline(file, text, ')');
  std::string skipped;
  for (int field = 3; field < 14; ++field) file >> skipped;
  double user = 0, system = 0;
  file >> user >> system;
  return (user + system) * 1000 / static_cast<double>(sysconf(_SC_CLK_TCK));
}

void WritePfm(const fs::path& path, const cv::Mat1f& values) {
  std::ofstream file(path, std::ios::binary);
  file << "Pf\n" << values.cols << " " << values.rows << "\n-1\n";  // little-endian, last row first
  for (int v = values.rows - 1; v >= 0; --v) {
    file.write(reinterpret_cast<const char*>(values[v]),
               static_cast<std::streamsize>(sizeof(float)) * values.cols);
  }
}

// The scene in Middlebury's layout of 2014. Rendering the synthetic scene anew for every frame
// would cost several times what the graph does.
void WriteScene(const fs::path& folder, const BenchFrame& bench) {
  fs::create_directories(folder);
  cv::imwrite(folder / "im0.png", bench.frame.left);
  cv::imwrite(folder / "im1.png", bench.frame.right);
  cv::Mat1f truth = bench.frame.truth.left.clone();
  for (float& disparity : truth) {
    if (std::isnan(disparity)) disparity = std::numeric_limits<float>::infinity();
  }
  WritePfm(folder / "disp0.pfm", truth);
  const RectifiedPair& pair = bench.rig.pair;
  const auto camera = [&](double cx) {
    return fmt::format("[{} 0 {}; 0 {} {}; 0 0 1]", pair.focal_px, cx, pair.focal_px, pair.cy);
  };
  std::ofstream(folder / "calib.txt")
      << "cam0=" << camera(pair.cx) << "\ncam1=" << camera(pair.cx_right)
      << "\nbaseline=" << pair.baseline_m * 1000 << "\n";
}

// Newest status of each stage; listens to nothing else, as that would cost the graph CPU time.
class StatusWatch {
 public:
  StatusWatch()
      : receiver_(kDefaultLcmUrl, "", {kStatusChannel},
                  [this](std::string_view, std::span<const uint8_t> bytes) {
                    const Result<StageStatus> status = DecodeStatus(bytes);
                    const std::lock_guard lock(mutex_);
                    if (status) newest_[status->stage] = *status;
                  }) {}

  std::map<std::string, StageStatus> Newest() {
    const std::lock_guard lock(mutex_);
    return newest_;
  }

 private:
  std::mutex mutex_;
  std::map<std::string, StageStatus> newest_;
  Receiver receiver_;
};

// Frames that a stage did not answer, and in which way.
nlohmann::ordered_json DroppedBy(const StageStatus& status) {
  return {{"skipped", status.frames_skipped},
          {"incomplete", status.frames_incomplete},
          {"gaps", status.sequence_gaps},
          {"failed", status.frames_failed}};
}

int Run(const std::string& preset, const std::string& hosting, const std::string& source,
        double rate_hz, double seconds, int load) {
  // Each of them computes without end, and needs a whole core.
  std::vector<std::unique_ptr<Process>> others;
  for (int i = 0; i < load; ++i) {
    others.push_back(
        std::make_unique<Process>(std::vector<std::string>{"sh", "-c", "while :; do :; done"}));
  }
  StatusWatch watch;
  const Stages stages = StagesOf(hosting);
  const std::string& answering = stages.back();
  const auto frames = static_cast<int64_t>(std::ceil(rate_hz * seconds));
  std::map<std::string, std::unique_ptr<Process>> processes;
  std::string all;
  const auto start = [&](const std::string& stage, const std::vector<std::string>& flags) {
    std::vector<std::string> command = {std::string(SPROUT_BINARY_DIR) + "/sprout-" + stage,
                                        "--config", preset, "--log-level", "debug"};
    command.insert(command.end(), flags.begin(), flags.end());
    processes[stage] = std::make_unique<Process>(command);
  };
  for (const std::string& stage : stages) {
    start(stage, {});
    all += (all.empty() ? "" : ",") + stage;
  }
  start("capture", {"--source", source, "--loop", "--rate", std::to_string(rate_hz), "--wait-for",
                    all, "--frames", std::to_string(frames)});
  std::map<std::string, double> cpu_ms;
  std::map<std::string, StageStatus> last;
  using Clock = std::chrono::steady_clock;
  const auto deadline = Clock::now() + std::chrono::duration<double>(seconds * 1.2 + 30);
  while (last[answering].newest_frame.seq < frames - 1 && Clock::now() < deadline) {
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    last = watch.Newest();
    for (const auto& [stage, process] :
         processes) {  // sprout-pipeline tells its steps' states, too
      cpu_ms[stage] = std::max(cpu_ms[stage], CpuMs(last[stage].pid));
    }
    // The last frame itself may be the one that was lost.
    if (last["capture"].state == StageStatus::State::kStopped) {
      std::this_thread::sleep_for(std::chrono::seconds(3));
      last = watch.Newest();
      break;
    }
  }
  const StageStatus& answered = last[answering];
  const int64_t lost = frames - answered.frames_out;
  nlohmann::ordered_json result;
  result["preset"] = preset;
  result["hosting"] = hosting;
  result["fps"] = rate_hz;
  result["load"] = load;
  result["captured"] = last["capture"].frames_out;
  result["answered"] = answered.frames_out;
  std::vector<std::string> all_stages = {"capture"};
  all_stages.insert(all_stages.end(), stages.begin(), stages.end());
  FrameTimes times;
  for (const auto& [stage, process] : processes) times.Read(stage, process->Output());
  result.update(times.Summarise(all_stages, rate_hz));
  for (const std::string& stage : all_stages) result["dropped"][stage] = DroppedBy(last[stage]);
  double total = 0;
  for (const auto& [stage, ms] : cpu_ms) total += ms / static_cast<double>(frames);
  result["cpu_ms_per_frame"] = total;
  for (const auto& [stage, ms] : cpu_ms) {
    result["cpu_ms_per_frame_of"][stage] = ms / static_cast<double>(frames);
  }
  std::cout << result.dump() << std::endl;
  return lost == 0 ? 0 : 3;
}

}  // namespace
}  // namespace sprout

int main(int argc, char** argv) {
  const std::string hosting = argc == 7 || argc == 8 ? argv[2] : "";
  if (hosting != "stages" && hosting != "pipeline") {
    std::cerr
        << "usage: sprout_bench_graph PRESET stages|pipeline WxH RATE_HZ SECONDS FOLDER [LOAD]\n";
    return 2;
  }
  try {
    cv::Size size;
    const char* data = std::getenv("SPROUT_DATA");
    if (data == nullptr || std::sscanf(argv[3], "%dx%d", &size.width, &size.height) != 2) {
      std::cerr << "sprout_bench_graph: SPROUT_DATA is not set, or the size is not WxH\n";
      return 2;
    }
    const std::string folder = argv[6];
    sprout::WriteScene(
        folder, sprout::LoadBenchFrame(std::string(data) + "/middlebury/full/Monopoly", size));
    return sprout::Run(argv[1], hosting, "middlebury:" + folder, std::stod(argv[4]),
                       std::stod(argv[5]), argc == 8 ? std::stoi(argv[7]) : 0);
  } catch (const std::exception& e) {
    std::cerr << "sprout_bench_graph: " << e.what() << "\n";
    return 1;
  }
}
