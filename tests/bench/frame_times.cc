#include "tests/bench/frame_times.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <deque>
#include <sstream>

namespace sprout {
namespace {

double Quantile(std::vector<double> values, double share) {
  if (values.empty()) return std::nan("");
  std::ranges::sort(values);
  const auto rank = static_cast<size_t>(std::ceil(share * static_cast<double>(values.size())));
  return values[std::max<size_t>(rank, 1) - 1];
}

}  // namespace

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
  std::map<std::string, std::vector<double>> moved;
  double worst = 0;
  int64_t too_old = 0;
  for (const auto& [seq, answer] : answering->second) {
    double worked_ms = 0;
    double age_ms = 0;  // behind the stage before
    for (const std::string& stage : stages) {
      const auto& of_stage = times_.at(stage);
      const auto it = of_stage.find(seq);
      if (it == of_stage.end()) continue;
      const Times& times = it->second;
      worked_ms += times.worked_ms;
      moved[stage].push_back(times.age_ms - times.worked_ms - times.waited_ms - age_ms);
      age_ms = times.age_ms;
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
  for (const std::string& stage : stages) {
    std::vector<double> waited, worked;
    for (const auto& [seq, times] : times_.at(stage)) {
      waited.push_back(times.waited_ms);
      worked.push_back(times.worked_ms);
    }
    result["of"][stage] = {{"worked_p50_ms", Quantile(worked, 0.5)},
                           {"waited_p50_ms", Quantile(waited, 0.5)},
                           {"waited_p99_ms", Quantile(waited, 0.99)},
                           {"moved_p50_ms", Quantile(moved[stage], 0.5)},
                           {"moved_p99_ms", Quantile(moved[stage], 0.99)}};
  }
  return result;
}

}  // namespace sprout
