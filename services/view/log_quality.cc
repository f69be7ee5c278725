#include "services/view/log_quality.h"

#include <algorithm>
#include <chrono>
#include <exception>
#include <memory>
#include <string>

#include "common/app/log.h"
#include "common/app/low_priority.h"
#include "common/core/sleep.h"
#include "common/measure/frame_quality.h"
#include "services/view/decoded_frame.h"

namespace sprout::view {
namespace {

constexpr std::chrono::milliseconds kPoll{50};

// A frame without the parts that are not rated, and those that take long to decode.
StoredFramePtr Rated(const StoredFrame& frame) {
  auto rated = std::make_shared<StoredFrame>(frame);
  for (const Part part : {Part::kPrior, Part::kUnfilled, Part::kDepth, Part::kCloud}) {
    rated->parts[static_cast<size_t>(part)] = nullptr;
  }
  return rated;
}

std::string WhyOf(const FrameQuality& quality) {
  std::string text;
  for (const QualityColumn& column : QualityColumns()) {
    if (!column.value(quality)) continue;
    if (!text.empty()) text += ", ";
    text += std::string(column.name) + " " + QualityText(column, quality);
  }
  return text;
}

}  // namespace

std::vector<int64_t> SpreadOrder(int64_t count, int64_t most) {
  std::vector<int64_t> order;
  const int64_t chosen = std::min(count, most);
  int64_t slots = 1;
  while (slots < chosen) slots *= 2;
  // The bits of 0, 1, 2, ... from behind: 0, ½, ¼, ¾, ...
  for (int64_t i = 0; i < slots; ++i) {
    int64_t reversed = 0;
    for (int64_t bit = 1, mirror = slots / 2; bit < slots; bit *= 2, mirror /= 2) {
      if ((i & bit) != 0) reversed |= mirror;
    }
    if (reversed < chosen) order.push_back(reversed * count / chosen);
  }
  return order;
}

LogQuality::LogQuality(LogFile& log)
    : log_(log), thread_([this](const std::stop_token& stop) { Run(stop); }) {}

void LogQuality::Run(const std::stop_token& stop) {
  LowerPriority();
  while (log_.progress() < 1) {
    if (!SleepFor(kPoll, stop)) return;
  }
  for (const int64_t key : SpreadOrder(log_.keys().last + 1, kMaxFrames)) {
    if (stop.stop_requested()) return;
    try {
      const StoredFramePtr stored = log_.Get(key);
      if (!stored) continue;
      // What cannot be decoded counts as missing here; the page reports it when the frame is
      // opened.
      const FrameQuality quality =
          QualityOf(DecodedFrame(Rated(*stored), [](Part, const std::string&) {}).ToFrame());
      const auto score = quality.score();
      log_.SetQuality(
          key, {.value = score.value_or(0), .why = score ? WhyOf(quality) : "no disparity map"});
    } catch (const std::exception& e) {  // out of memory
      LogLine(LogLevel::kWarning, "quality of frame {}: {}", key, e.what());
    }
  }
  log_.Settle();
}

}  // namespace sprout::view
