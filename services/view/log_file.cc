#include "services/view/log_file.h"

#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <exception>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

#include "common/app/compute.h"
#include "common/app/log.h"
#include "common/bus/channels.h"
#include "common/core/printable.h"
#include "common/core/sleep.h"
#include "common/measure/frame_quality.h"
#include "common/messages/codec.h"
#include "services/view/decoded_frame.h"
#include "services/view/packet.h"

namespace sprout::view {
namespace {

// How often pages learn of new frames.
constexpr std::chrono::milliseconds kNotifyPeriod{200};

StatusBoard::Clock::time_point AsTime(int64_t utime) {
  return StatusBoard::Clock::time_point(std::chrono::microseconds(utime));
}

constexpr std::chrono::milliseconds kPoll{50};

// A frame with the parts by which it is rated: others would only take time to decode.
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

LogFile::LogFile(const std::filesystem::path& path, std::string prefix, StatusHistory& statuses,
                 std::function<void()> changed)
    : path_(path),
      prefix_(std::move(prefix)),
      statuses_(statuses),
      changed_(std::move(changed)),
      reader_(path),
      fetcher_(path),
      index_({.prefix = prefix_}),
      thread_([this](const std::stop_token& stop) { Read(stop); }) {}

void LogFile::Read(const std::stop_token& stop) {
  auto next = std::chrono::steady_clock::now();
  try {
    LogEvent event;
    while (!stop.stop_requested() && reader_.Next(event)) {
      Add(event);
      progress_ = static_cast<double>(reader_.position()) / static_cast<double>(reader_.size());
      if (std::chrono::steady_clock::now() < next) continue;
      next = std::chrono::steady_clock::now() + kNotifyPeriod;
      changed_();
    }
  } catch (const std::exception& e) {
    LogLine(LogLevel::kError, e.what());
    const std::lock_guard lock(mutex_);
    complaint_ = e.what();
  }
  {
    const std::lock_guard lock(mutex_);
    if (complaint_.empty() && !reader_.damage().empty()) {
      complaint_ = fmt::format("{}: damaged in {} places; sprout-log info says where",
                               path_.string(), reader_.damage().size());
    } else if (complaint_.empty() && index_.frames().empty()) {
      const std::string other = index_.OtherPrefixText();
      complaint_ = path_.string() + ": no frames" + (other.empty() ? "" : "; " + other);
    }
    if (complaint_.empty() && refused_ > 0) {
      complaint_ = fmt::format("{}: messages that are not used: {}, the first {}", path_.string(),
                               refused_, first_refused_);
    }
    if (!complaint_.empty()) LogLine(LogLevel::kWarning, complaint_);
  }
  progress_ = 1;
  if (!stop.stop_requested()) changed_();
}

void LogFile::Add(const LogEvent& event) {
  if (event.channel == prefix_ + std::string(kStatusChannel)) {
    if (const Result<StageStatus> status = DecodeStatus(event.data)) {
      statuses_.Add(*status, event.utime, AsTime(event.utime));
    }
    return;
  }
  const std::lock_guard lock(mutex_);
  index_.Add(event, [this](const LogEvent& refused, const std::string& why) {
    if (refused_++ > 0) return;
    first_refused_ =
        fmt::format("{} at byte {}: {}", Printable(refused.channel), refused.offset, why);
  });
}

StoredBytes LogFile::Fetch(int64_t offset) const {
  const std::lock_guard lock(fetch_mutex_);
  const LogEvent event = fetcher_.Fetch(offset);
  return std::make_shared<const std::vector<uint8_t>>(event.data.begin(), event.data.end());
}

StoredFramePtr LogFile::Newest() const { return Get(keys().last); }

StoredFramePtr LogFile::Get(int64_t key) const {
  auto frame = std::make_shared<StoredFrame>();
  IndexedFrame places{FrameId{}};
  {
    const std::lock_guard lock(mutex_);
    if (key < 0 || key >= std::ssize(index_.frames())) return nullptr;
    places = index_.At(static_cast<size_t>(key));
  }
  frame->id = places.id;
  frame->key = key;
  try {
    for (const Part part : kAllParts) {
      if (!places.Has(part)) continue;
      frame->parts[static_cast<size_t>(part)] = Fetch(places.offset(part));
      ++frame->version;
    }
  } catch (const LogError& e) {  // the file was changed meanwhile
    unreadable_.Warn(e.what());
    return nullptr;
  }
  return frame;
}

KeyRange LogFile::keys() const {
  const std::lock_guard lock(mutex_);
  return {0, std::ssize(index_.frames()) - 1};
}

std::optional<int64_t> LogFile::KeyOf(int64_t seq) const {
  const std::lock_guard lock(mutex_);
  const auto& frames = index_.frames();
  const auto found = std::ranges::find(frames, seq, [](const auto& frame) { return frame.id.seq; });
  if (found == frames.end()) return std::nullopt;
  return found - frames.begin();
}

double LogFile::progress() const { return progress_; }

std::string LogFile::complaint() const {
  const std::lock_guard lock(mutex_);
  return complaint_;
}

void LogFile::SetQuality(int64_t key, Quality quality) {
  const std::lock_guard lock(mutex_);
  qualities_[key] = std::move(quality);
}

std::string LogFile::TimeLineText(int buckets) const {
  const std::lock_guard lock(mutex_);
  const auto count = static_cast<int64_t>(index_.frames().size());
  const int64_t used = std::min<int64_t>(buckets, count);
  nlohmann::json list = nlohmann::json::array();
  for (int64_t i = 0; i < used; ++i) {
    const auto begin = qualities_.lower_bound(i * count / used);
    const auto end = qualities_.lower_bound((i + 1) * count / used);
    const auto worst = std::min_element(
        begin, end, [](const auto& a, const auto& b) { return a.second.value < b.second.value; });
    const int64_t chosen = worst == end ? i * count / used : worst->first;
    const FrameId& id = index_.frames()[static_cast<size_t>(chosen)].id;
    nlohmann::json bucket{{"key", chosen}, {"seq", id.seq}, {"utime", id.utime}};
    if (worst != end) {
      bucket.update({{"quality", worst->second.value}, {"why", worst->second.why}});
    }
    list.push_back(std::move(bucket));
  }
  return JsonText({{"first", 0},
                   {"last", count - 1},
                   {"complete", progress_ >= 1},
                   {"settled", settled_.load()},
                   {"complaint", complaint_},
                   {"buckets", std::move(list)}});
}

std::vector<int64_t> SpreadOrder(int64_t count, int64_t most) {
  std::vector<int64_t> order;
  const int64_t chosen = std::min(count, most);
  int64_t slots = 1;
  while (slots < chosen) slots *= 2;
  // Van der Corput's sequence, the bits of 0, 1, 2, ... reversed: 0, ½, ¼, ¾, ...
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
