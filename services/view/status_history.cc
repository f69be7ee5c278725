#include "services/view/status_history.h"

#include <nlohmann/json.hpp>

#include "services/view/packet.h"

namespace sprout::view {
namespace {

// Bounds the memory, since a process may send any name of a stage.
constexpr size_t kMaxStages = 32;

int64_t LostOf(const StageStatus& status) {
  return status.frames_skipped + status.frames_incomplete + status.frames_failed +
         status.frames_degenerate + status.sequence_gaps;
}

}  // namespace

void StatusHistory::Add(const StageStatus& status, int64_t utime,
                        StatusBoard::Clock::time_point now) {
  const std::lock_guard lock(mutex_);
  board_.Add(status, now);
  newest_ = now;
  if (samples_.size() == kMaxStages && !samples_.contains(status.stage)) return;
  Samples& kept = samples_[status.stage];
  const int64_t seen = kept.seen++;
  if (seen % kept.step != 0) return;
  // The clock was set back: plots need times that rise.
  while (!keep_all_ && !kept.samples.empty() && kept.samples.back().utime > utime) {
    kept.samples.pop_back();
  }
  kept.samples.push_back({utime, seen, status});
  if (kept.samples.size() <= kMaxSamples) return;
  if (keep_all_) {
    kept.step *= 2;
    std::erase_if(kept.samples, [&](const Sample& s) { return s.seen % kept.step != 0; });
  } else {
    kept.samples.pop_front();
  }
}

std::string StatusHistory::BoardText(StatusBoard::Clock::time_point now) const {
  const std::lock_guard lock(mutex_);
  return BoardJson(board_.Rows(now));
}

StatusBoard::Clock::time_point StatusHistory::newest() const {
  const std::lock_guard lock(mutex_);
  return newest_;
}

std::string StatusHistory::HistoryText() const {
  const std::lock_guard lock(mutex_);
  nlohmann::json stages = nlohmann::json::object();
  for (const auto& [stage, kept] : samples_) {
    nlohmann::json columns;  // not empty: each stage has a sample
    for (const Sample& sample : kept.samples) {
      columns["t"].push_back(static_cast<double>(sample.utime) * 1e-6);
      columns["rate_hz"].push_back(sample.status.rate_hz);
      columns["age_p50_ms"].push_back(sample.status.age.p50_ms);
      columns["age_p99_ms"].push_back(sample.status.age.p99_ms);
      columns["lost"].push_back(LostOf(sample.status));
      columns["bad"].push_back(sample.status.bad_messages);
      columns["rss_mb"].push_back(static_cast<double>(sample.status.rss_bytes) / (1 << 20));
    }
    stages[stage] = std::move(columns);
  }
  return JsonText(stages);
}

}  // namespace sprout::view
