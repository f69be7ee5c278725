#include "services/view/log_file.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "common/bus/channels.h"
#include "common/messages/codec.h"
#include "services/log/channels.h"
#include "services/view/packet.h"

namespace sprout::view {
namespace {

// Parts of one frame stand close together in a log.
constexpr size_t kLookBack = 64;

// Whoever looks is told of new frames this often.
constexpr std::chrono::milliseconds kTell{200};

constexpr int64_t kNowhere = -1;
constexpr size_t kMaxRigs = 1000;

top::StatusBoard::Clock::time_point AsTime(int64_t utime) {
  return top::StatusBoard::Clock::time_point(std::chrono::microseconds(utime));
}

}  // namespace

LogFile::LogFile(const std::filesystem::path& path, std::string prefix, StatusBook& statuses,
                 std::function<void()> changed)
    : path_(path),
      prefix_(std::move(prefix)),
      statuses_(statuses),
      changed_(std::move(changed)),
      reader_(path),
      fetcher_(path),
      thread_([this](const std::stop_token& stop) { Read(stop); }) {}

void LogFile::Read(const std::stop_token& stop) {
  auto next = std::chrono::steady_clock::now();
  try {
    LogEvent event;
    while (!stop.stop_requested() && reader_.Next(event)) {
      Add(event);
      progress_ = static_cast<double>(reader_.position()) / static_cast<double>(reader_.size());
      if (std::chrono::steady_clock::now() < next) continue;
      next = std::chrono::steady_clock::now() + kTell;
      changed_();
    }
  } catch (const std::exception& e) {
    spdlog::error(e.what());
    const std::lock_guard lock(mutex_);
    complaint_ = e.what();
  }
  {
    const std::lock_guard lock(mutex_);
    if (complaint_.empty() && !reader_.damage().empty()) {
      complaint_ = fmt::format("{}: damaged in {} places; sprout-log info says where",
                               path_.string(), reader_.damage().size());
    } else if (complaint_.empty() && entries_.empty()) {
      complaint_ = path_.string() + ": no frames";
      if (!other_channel_.empty()) {
        complaint_ += "; there are channels as " + other_channel_ + ", see --channel-prefix";
      }
    }
    if (!complaint_.empty()) spdlog::warn(complaint_);
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
  const std::optional<Part> part = log::PartOfChannel(event.channel, prefix_);
  const std::lock_guard lock(mutex_);
  if (!part) {
    if (log::TypeOfChannel(event.channel)) other_channel_ = event.channel;
    return;
  }
  const Result<FrameId> id = DecodeFrameId(event.data);
  if (!id || TypeOf(event.data) != TypeOf(*part)) return;
  if (*part == Part::kRig) {
    if (rigs_.size() < kMaxRigs) rigs_.emplace(id->rig_id, event.offset);
    return;
  }
  FindOrStart(*id, event.utime).offsets[static_cast<size_t>(*part)] = event.offset;
}

LogFile::Entry& LogFile::FindOrStart(const FrameId& id, int64_t utime) {
  const size_t back = std::min(kLookBack, entries_.size());
  const auto found = std::find_if(entries_.rbegin(), entries_.rbegin() + static_cast<long>(back),
                                  [&](const Entry& entry) { return entry.id == id; });
  if (found != entries_.rbegin() + static_cast<long>(back)) return *found;
  Entry& entry = entries_.emplace_back();
  entry.id = id;
  entry.utime = utime;
  entry.offsets.fill(kNowhere);
  return entry;
}

StoredBytes LogFile::Fetch(int64_t offset) const {
  const std::lock_guard lock(fetch_mutex_);
  const LogEvent event = fetcher_.Fetch(offset);
  return std::make_shared<const std::vector<uint8_t>>(event.data.begin(), event.data.end());
}

StoredFramePtr LogFile::Newest() const { return Get(keys().last); }

StoredFramePtr LogFile::Get(int64_t key) const {
  auto frame = std::make_shared<StoredFrame>();
  std::array<int64_t, kPartCount> offsets{};
  {
    const std::lock_guard lock(mutex_);
    if (key < 0 || key >= std::ssize(entries_)) return nullptr;
    const Entry& entry = entries_[static_cast<size_t>(key)];
    frame->id = entry.id;
    offsets = entry.offsets;
    const auto rig = rigs_.find(entry.id.rig_id);
    if (rig != rigs_.end()) offsets[static_cast<size_t>(Part::kRig)] = rig->second;
  }
  frame->key = key;
  try {
    for (size_t i = 0; i < offsets.size(); ++i) {
      if (offsets[i] == kNowhere) continue;
      frame->parts[i] = Fetch(offsets[i]);
      ++frame->version;
    }
  } catch (const LogError& e) {  // the file was changed meanwhile
    spdlog::warn(e.what());
    return nullptr;
  }
  return frame;
}

KeyRange LogFile::keys() const {
  const std::lock_guard lock(mutex_);
  return {0, static_cast<int64_t>(entries_.size()) - 1};
}

std::optional<int64_t> LogFile::KeyOf(int64_t seq) const {
  const std::lock_guard lock(mutex_);
  const auto found = std::find_if(entries_.begin(), entries_.end(),
                                  [&](const Entry& entry) { return entry.id.seq == seq; });
  if (found == entries_.end()) return std::nullopt;
  return found - entries_.begin();
}

double LogFile::progress() const { return progress_; }

std::string LogFile::complaint() const {
  const std::lock_guard lock(mutex_);
  return complaint_;
}

void LogFile::SetQuality(int64_t key, Quality quality) {
  const std::lock_guard lock(mutex_);
  entries_.at(static_cast<size_t>(key)).quality = std::move(quality);
}

std::string LogFile::TimeLineText(int buckets) const {
  const std::lock_guard lock(mutex_);
  const auto count = static_cast<int64_t>(entries_.size());
  const int64_t used = std::min<int64_t>(buckets, count);
  nlohmann::json list = nlohmann::json::array();
  for (int64_t i = 0; i < used; ++i) {
    int64_t chosen = i * count / used;
    const int64_t end = (i + 1) * count / used;
    double least = std::numeric_limits<double>::infinity();
    for (int64_t key = chosen; key < end; ++key) {
      const auto& quality = entries_[static_cast<size_t>(key)].quality;
      if (!quality || quality->value >= least) continue;
      least = quality->value;
      chosen = key;
    }
    const Entry& entry = entries_[static_cast<size_t>(chosen)];
    nlohmann::json bucket{{"key", chosen}, {"seq", entry.id.seq}, {"utime", entry.id.utime}};
    if (entry.quality)
      bucket.update({{"quality", entry.quality->value}, {"why", entry.quality->why}});
    list.push_back(std::move(bucket));
  }
  return JsonText({{"first", 0},
                   {"last", count - 1},
                   {"complete", progress_ >= 1},
                   {"settled", settled_.load()},
                   {"complaint", complaint_},
                   {"buckets", std::move(list)}});
}

}  // namespace sprout::view
