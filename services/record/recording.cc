#include "services/record/recording.h"

#include <fmt/core.h>

#include <algorithm>
#include <new>
#include <opencv2/core.hpp>
#include <utility>

#include "common/app/log.h"
#include "common/app/supervision.h"
#include "common/bus/channels.h"
#include "common/messages/codec.h"

namespace sprout::record {
namespace {

constexpr size_t kMaxQueuedBytes = size_t{1} << 29;

// Frames without a confidence until a warning.
constexpr int64_t kMaxUnjudged = 30;
constexpr char kUnjudgedText[] =
    "--trigger-confidence cannot trigger: frames come, and no SPROUT_CONFIDENCE, which grow sends "
    "with grow { publish_confidence: true }, not in preset fast";

// The part whose messages are counted as frames: the first of the channels that every frame has.
// RIG comes once a second.
std::optional<Part> CountedPart(const std::vector<std::string>& channels) {
  for (const PartRow& row : kPartTable) {
    if (row.part != Part::kRig && std::ranges::find(channels, row.channel) != channels.end()) {
      return row.part;
    }
  }
  return std::nullopt;
}

std::vector<std::string_view> Subscriptions(const RecordingOptions& options) {
  std::vector<std::string_view> channels(options.channels.begin(), options.channels.end());
  if (options.trigger_channel) channels.emplace_back(*options.trigger_channel);
  if (options.trigger_confidence) channels.push_back(ChannelOf(Part::kConfidence));
  std::ranges::sort(channels);
  const auto twice = std::ranges::unique(channels);
  channels.erase(twice.begin(), twice.end());
  return channels;
}

// Channels whose silence is warned of: each of them if they were named, else LEFT.
std::vector<std::string_view> Awaited(const RecordingOptions& options) {
  if (!options.named) return {ChannelOf(Part::kLeft)};
  return {options.channels.begin(), options.channels.end()};
}

}  // namespace

Recorder::Recorder(const std::optional<RingOptions>& ring, LogFolder& folder) : folder_(folder) {
  if (!ring) return;
  after_ = ring->after;
  ring_.emplace(ring->length, ring->max_bytes);
}

void Recorder::Add(RecordedEvent event) {
  if (!ring_) {
    ++unwritten_;
    return Write(event);
  }
  if (until_ && event.arrived <= *until_) {
    ++unwritten_;
    WriteMissing();  // a message may have come µs before the trigger that is handled first
    Write(event);
    ring_->Add(std::move(event));
  } else {
    ring_->Add(std::move(event));
    ++missing_;
    CloseIfApart();
  }
}

void Recorder::AddStatus(RecordedEvent event) {
  if (ring_ || folder_.is_open()) Add(std::move(event));
}

bool Recorder::Trigger(Time now) {
  if (!ring_) return false;
  ring_->Forget(now);
  if (until_ && now > *until_) CloseIfApart();
  const bool begins = !until_;
  if (begins) missing_ = ring_->events().size();
  WriteMissing();
  until_ = begins ? now + after_ : std::max(*until_, now + after_);
  return begins;
}

// Writes an event that is counted as unwritten so far.
void Recorder::Write(const RecordedEvent& event) {
  folder_.Write(event);
  --unwritten_;
}

void Recorder::WriteMissing() {
  const auto& events = ring_->events();
  unwritten_ += static_cast<int64_t>(missing_);
  for (; missing_ > 0; --missing_) Write(events[events.size() - missing_]);
}

void Recorder::CloseIfApart() {
  if (!until_ || missing_ < ring_->events().size()) return;
  until_.reset();
  folder_.Close();
}

Recording::Recording(const ServiceContext& context, RecordingOptions options, StageMonitor& monitor)
    : options_(std::move(options)),
      prefix_(context.prefix),
      monitor_(monitor),
      depth_every_(context.config.depth().every()),
      counted_part_(CountedPart(options_.channels)),
      queue_(kMaxQueuedBytes),
      folder_(options_.folder, [this] { return StatusEvent(); }),
      recorder_(options_.ring, folder_) {
  silence_.emplace(context, Awaited(options_), monitor_);
  if (options_.compress) compressor_.emplace(options_.jpeg_quality);
  receiver_.emplace(
      context.lcm_url, prefix_, Subscriptions(options_),
      [this](std::string_view channel, std::span<const uint8_t> bytes) { Receive(channel, bytes); },
      [this](std::string_view channel) { Drop(channel); });
  writing_ = std::jthread([this] { WriteAll(); });
}

RecordedEvent Recording::MakeEvent(std::string channel, std::span<const uint8_t> bytes) const {
  return {.utime = NowUtime(),
          .arrived = RecordedEvent::Clock::now(),
          .channel = prefix_ + std::move(channel),
          .data = {bytes.begin(), bytes.end()}};
}

RecordedEvent Recording::StatusEvent() const {
  return MakeEvent(std::string(kStatusChannel), EncodeStatus(monitor_.Snapshot()));
}

// Whether a message is the recorder's own. Its statuses are put into the log when they are made,
// since they could be lost on the bus; its SPROUT_PROCESS says nothing about the graph.
bool Recording::IsOwn(std::string_view channel, std::span<const uint8_t> bytes) const {
  const StageStatus own = monitor_.Snapshot();
  const auto is_own = [&own](const auto& said) {
    return said && said->stage == own.stage && said->host == own.host && said->pid == own.pid;
  };
  if (channel == kStatusChannel) return is_own(DecodeStatus(bytes));
  return channel == kProcessChannel && is_own(DecodeProcessInfo(bytes));
}

bool Recording::IsRecorded(std::string_view channel) const {
  return std::ranges::find(options_.channels, channel) != options_.channels.end();
}

void Recording::Receive(std::string_view channel, std::span<const uint8_t> bytes) try {
  const bool record = IsRecorded(channel);
  if (IsOwn(channel, bytes)) return;
  if (record) Hear(channel);
  if (const auto part = PartOf(channel); part && record) CountFrame(*part, bytes);
  if (channel == ChannelOf(Part::kConfidence) && std::exchange(unjudged_, 0) >= kMaxUnjudged) {
    monitor_.Resolve(kUnjudgedText);
  }
  if (record || channel == ChannelOf(Part::kConfidence)) {
    const auto kind = record ? QueuedEvent::Kind::kMessage : QueuedEvent::Kind::kTriggerOnly;
    if (!queue_.Put({.kind = kind, .event = MakeEvent(std::string(channel), bytes)})) {
      Drop(channel);
    }
  }
  if (channel == options_.trigger_channel) {
    heard_trigger_ = true;
    Trigger("a message on " + std::string(channel));
  }
} catch (const std::bad_alloc&) {
  Drop(channel);
}

// Lets silent channels be warned of at once: a misspelt name can then still be corrected.
void Recording::Hear(std::string_view channel) {
  if (!heard_.contains(channel)) heard_.emplace(channel);
  options_.named ? silence_->HeardSingle(channel) : silence_->HeardFrame();
}

void Recording::Drop(std::string_view channel) {
  ++dropped_;
  monitor_.BadMessage(channel, "came faster than the disk takes messages");
}

void Recording::CountFrame(Part part, std::span<const uint8_t> bytes) {
  if (part == Part::kRig) return;
  const Result<FrameId> id = DecodeFrameId(bytes);
  if (!id) return;  // recorded as it is; stages refuse it in a replay
  FrameId counted = *id;
  if (IsOfDepth(part)) counted.seq /= depth_every_;
  gaps_[part].Add(counted);
  int64_t gaps = 0;
  for (const auto& [of_part, seen] : gaps_) gaps += seen.count();
  monitor_.SetJoinerCounts(/*incomplete=*/0, gaps);
  if (part != counted_part_) return;
  if (options_.trigger_confidence && ++unjudged_ == kMaxUnjudged) {
    monitor_.Warn(kUnjudgedText);
    monitor_.HoldWarning(kUnjudgedText);
  }
  monitor_.FrameIn(/*skipped=*/false);
  monitor_.FrameOut(*id, StageMonitor::Clock::now(), /*degenerate=*/"");
}

void Recording::Trigger(const std::string& who) {
  static_cast<void>(
      queue_.Put({.kind = QueuedEvent::Kind::kTrigger,
                  .event = {.arrived = RecordedEvent::Clock::now(), .channel = {}, .data = {}},
                  .trigger = who}));
}

void Recording::PutStatus() {
  if (!queue_.Put({.kind = QueuedEvent::Kind::kOwnStatus, .event = StatusEvent()})) {
    Drop(kStatusChannel);
  }
}

void Recording::WriteAll() {
  Watchdog watchdog;
  try {
    while (!queue_.IsFinished()) {
      watchdog.Idle();
      if (auto item = queue_.TakeWithin(Watchdog::kIdlePeriod / 2)) Handle(std::move(*item));
    }
    monitor_.SetStopped();
    recorder_.Finish();
  } catch (const std::exception& error) {  // LogError, or no memory
    Fail(error.what());
  }
}

void Recording::Handle(QueuedEvent item) {
  if (item.kind == QueuedEvent::Kind::kTrigger) {
    return HandleTrigger(item.event.arrived, item.trigger);
  }
  if (item.kind == QueuedEvent::Kind::kOwnStatus) {
    folder_.RequireThere();
    return recorder_.AddStatus(std::move(item.event));
  }
  if (options_.trigger_confidence &&
      item.event.channel == prefix_ + std::string(ChannelOf(Part::kConfidence))) {
    CheckConfidence(item.event);
  }
  if (item.kind != QueuedEvent::Kind::kMessage) return;
  if (compressor_) Compress(item.event);
  recorder_.Add(std::move(item.event));
}

void Recording::Compress(RecordedEvent& event) {
  std::optional<std::vector<uint8_t>> smaller = compressor_->Compress(event.channel, event.data);
  if (!smaller) return;
  uncompressed_bytes_ += std::ssize(event.data);
  compressed_bytes_ += std::ssize(*smaller);
  event.data = *std::move(smaller);
}

void Recording::HandleTrigger(RecordedEvent::Clock::time_point now, const std::string& who) {
  if (!options_.ring)
    return LogLine(LogLevel::kInfo, "trigger ({}): without --ring all is written anyway", who);
  ++triggers_;
  const int64_t before = folder_.events();
  if (!recorder_.Trigger(now)) {  // may happen with every message, so no warning is printed
    LogLine(LogLevel::kDebug, "trigger ({}): the log continues", who);
    return monitor_.RecordWarning(fmt::format("trigger ({}): the log continues", who));
  }
  const auto& events = recorder_.ring()->events();
  const double held_s =
      events.empty() ? 0 : std::chrono::duration<double>(now - events.front().arrived).count();
  monitor_.Warn(fmt::format("trigger ({}): the {} messages of the last {:.1f} s are written", who,
                            folder_.events() - before, held_s));
}

void Recording::CheckConfidence(const RecordedEvent& event) {
  const Result<DecodedPart> decoded = DecodePart(Part::kConfidence, event.data);
  if (!decoded) return monitor_.BadMessage(event.channel, decoded.error().text);
  const auto& image = std::get<cv::Mat>(decoded->value);
  const double mean = cv::mean(image)[0] / 255;
  if (mean >= *options_.trigger_confidence) return;
  HandleTrigger(event.arrived,
                fmt::format("frame {}: mean confidence {:.3f}", decoded->id.seq, mean));
}

void Recording::Fail(const std::string& reason) {
  monitor_.Failure(reason);
  try {
    recorder_.Finish();  // on a full disk a status of 500 bytes often fits where an image did not
  } catch (const std::exception&) {
    LogLine(LogLevel::kDebug, "the log has no last status");
  }
  failed_ = true;
}

void Recording::Finish() {
  receiver_.reset();
  silence_.reset();
  queue_.Close();
  writing_.join();
  unwritten_ = static_cast<int64_t>(queue_.size());
  // At least one: the message at which it failed may not have reached the recorder.
  if (failed_) unwritten_ += std::max<int64_t>(recorder_.unwritten(), 1);
  if (heard_.empty() && !failed_) {
    monitor_.Warn("nothing came; is the graph running with this --lcm-url and --channel-prefix?");
  }
}

bool Recording::IsWhole() const { return !failed_ && dropped_ == 0 && !heard_.empty(); }

std::string Recording::Summary() const {
  std::string gaps;
  for (const auto& [part, seen] : gaps_) {
    if (seen.count() > 0) gaps += fmt::format(" {} {}", ChannelOf(part), seen.count());
  }
  std::string text = fmt::format(
      "{} messages, {:.1f} MB in {} logs; lost: {} dropped, {} unwritten; frame numbers missing:{}",
      folder_.events(), static_cast<double>(folder_.bytes()) / 1e6, folder_.files(),
      dropped_.load(), unwritten_, gaps.empty() ? " none" : gaps);
  if (const EventRing* ring = recorder_.ring()) {
    text += fmt::format("; {} triggers, {} messages did not fit into the ring", triggers_,
                        ring->not_fitted());
  }
  if (compressed_bytes_ > 0) {
    text += fmt::format("; {:.1f} MB of messages became {:.1f} MB",
                        static_cast<double>(uncompressed_bytes_) / 1e6,
                        static_cast<double>(compressed_bytes_) / 1e6);
  }
  if (options_.trigger_channel && !heard_trigger_) {
    text += "; nothing came on --trigger-channel " + *options_.trigger_channel;
  }
  for (const std::string& channel : options_.channels) {
    if (options_.named && !heard_.contains(channel)) text += "; nothing came on " + channel;
  }
  if (folder_.deleted() > 0) text += fmt::format("; {} older logs deleted", folder_.deleted());
  return text;
}

}  // namespace sprout::record
