#include "services/view/status_history.h"

#include <nlohmann/json.hpp>

#include "services/view/packet.h"

namespace sprout::view {
namespace {

// Names are free, so anybody could invent more.
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
  if (courses_.size() == kMaxStages && !courses_.contains(status.stage)) return;
  Course& course = courses_[status.stage];
  const int64_t seen = course.seen++;
  if (seen % course.step != 0) return;
  // The clock was set back: plots would run to and fro.
  while (!keep_all_ && !course.samples.empty() && course.samples.back().utime > utime) {
    course.samples.pop_back();
  }
  course.samples.push_back({utime, seen, status});
  if (course.samples.size() <= kMaxSamples) return;
  if (keep_all_) {
    course.step *= 2;
    std::erase_if(course.samples, [&](const Sample& s) { return s.seen % course.step != 0; });
  } else {
    course.samples.pop_front();
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
  for (const auto& [stage, course] : courses_) {
    nlohmann::json columns;  // a course has a sample at least
    for (const Sample& sample : course.samples) {
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
