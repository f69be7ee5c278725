#include "common/app/silence_watch.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <optional>

#include "common/bus/lcm_url.h"
#include "common/bus/receiver.h"
#include "common/bus/udpm_socket.h"
#include "common/core/sleep.h"

namespace sprout {
namespace {

// How long all channels are listened to: capture sends RIG, and everybody STATUS, once a second.
constexpr std::chrono::milliseconds kSurveyTime{1200};

// How long the datagrams of a message are on the way, at most.
constexpr std::chrono::milliseconds kOnTheWay{200};

// Channels that are named; anybody can invent more.
constexpr size_t kMaxNamed = 20;

void Count(std::string_view channel, MessageCounts& counts) {
  if (counts.size() < kMaxNamed || counts.contains(std::string(channel))) {
    ++counts[std::string(channel)];
  }
}

// Messages heard on all channels: those of which the first datagram came, except for the last ones,
// and whole ones.
struct Survey {
  MessageCounts begun;
  MessageCounts whole;

  Survey(const std::string& url, const std::stop_token& stop) {
    if (IsUdpm(url)) {
      const auto newest = std::chrono::steady_clock::now() + kSurveyTime - kOnTheWay;
      const auto count = [this, newest](std::string_view channel) {
        if (std::chrono::steady_clock::now() < newest) Count(channel, begun);
        return size_t{1};  // byte
      };
      UdpmSocket socket(url, count, /*short_only=*/false);
      const std::jthread listening([&](const std::stop_token& end) {
        socket.Receive(
            end, [this](const DatagramJoiner::Message& message) { Count(message.channel, whole); });
      });
      SleepFor(kSurveyTime, stop);
    } else {
      const Receiver receiver(
          url, "", {Receiver::kAllChannels}, [](std::string_view, std::span<const uint8_t>) {},
          [this](std::string_view channel) { Count(channel, whole); }, /*max_queued_bytes=*/0);
      SleepFor(kSurveyTime, stop);
    }
  }
};

// Channels whose messages do not come whole.
std::vector<std::string> TornChannels(const MessageCounts& begun, const MessageCounts& whole) {
  std::vector<std::string> torn;
  for (const auto& [channel, count] : begun) {
    const auto found = whole.find(channel);
    if (count > (found == whole.end() ? 0 : found->second)) torn.push_back(channel);
  }
  return torn;
}

// Channels of the same name behind other prefixes.
std::vector<std::string> OtherPrefixes(const std::string& missing, const MessageCounts& present) {
  std::vector<std::string> others;
  const std::string name = missing.substr(std::min(missing.find("SPROUT_"), missing.size()));
  for (const auto& [channel, unused] : present) {
    if (!name.empty() && channel != missing && channel.ends_with(name)) others.push_back(channel);
  }
  return others;
}

std::string CountsText(const MessageCounts& counts) {
  std::vector<std::string> texts;
  for (const auto& [channel, count] : counts)
    texts.push_back(fmt::format("{} ({})", channel, count));
  return fmt::format("{}", fmt::join(texts, ", "));
}

bool IsOfConfidence(const std::string& channel) {
  return channel.ends_with("SPROUT_CONFIDENCE") || channel.ends_with("SPROUT_SIGMA");
}

// Twins that are remembered; anybody can invent more.
constexpr size_t kMaxTwins = 32;

}  // namespace

std::string SilenceText(const std::vector<std::string>& needed, const MessageCounts& counts,
                        const MessageCounts& present, const MessageCounts& begun) {
  std::vector<std::string> missing;
  std::vector<std::string> elsewhere;
  for (const std::string& channel : needed) {
    if (counts.contains(channel)) continue;
    missing.push_back(channel);
    for (std::string& other : OtherPrefixes(channel, present))
      elsewhere.push_back(std::move(other));
  }
  std::string text = missing.empty() ? "no frame has all its messages, though every channel is "
                                       "heard: have they one utime, seq and rig_id, that of "
                                       "capture, and do they come in time?"
                                     : fmt::format("nothing heard on {}", fmt::join(missing, ", "));
  if (!missing.empty() && std::ranges::all_of(missing, IsOfConfidence)) {
    text += ", which grow sends with grow { publish_confidence: true }, not in preset fast";
  }
  text += present.empty() ? "; nothing else is heard either"
                          : "; heard in a second: " + CountsText(present);
  if (const std::vector<std::string> torn = TornChannels(begun, present); !torn.empty()) {
    text += fmt::format("; messages of {} lack datagrams, which the network or this host loses",
                        fmt::join(torn, ", "));
  }
  if (!elsewhere.empty()) {
    text += fmt::format("; with another --channel-prefix: {}", fmt::join(elsewhere, ", "));
  }
  return text;
}

SilenceWatch::SilenceWatch(const ServiceContext& context, std::vector<std::string_view> channels,
                           StageMonitor& monitor, std::chrono::milliseconds patience)
    : url_(context.lcm_url),
      prefix_length_(context.prefix.size()),
      monitor_(monitor),
      patience_(patience),
      wait_(patience) {
  for (const std::string_view channel : channels) {
    needed_.push_back(context.prefix + std::string(channel));
  }
  thread_ = std::jthread([this](const std::stop_token& stop) { Watch(stop); });
}

void SilenceWatch::Heard(std::string_view channel) {
  const std::lock_guard lock(mutex_);
  for (const std::string& needed : needed_) {
    if (std::string_view(needed).substr(prefix_length_) == channel) ++counts_[needed];
  }
}

void SilenceWatch::HeardFrame() {
  const std::lock_guard lock(mutex_);
  counts_.clear();
  const Clock::time_point now = Clock::now();
  // A camera may be triggered once in ten seconds. A stage that starts knows no interval yet.
  if (heard_frame_)
    wait_ = std::clamp<Clock::duration>(3 * (now - last_frame_), patience_, 12 * patience_);
  heard_frame_ = true;
  last_frame_ = now;
  warned_ = false;
  for (const std::string& warning : warnings_) monitor_.Resolve(warning);
  warnings_.clear();
}

void SilenceWatch::HeardSingle(std::string_view channel) {
  Heard(channel);
  {
    const std::lock_guard lock(mutex_);
    if (!singles_.contains(channel)) singles_.emplace(channel);
    if (singles_.size() < needed_.size()) return;
  }
  HeardFrame();
}

void SilenceWatch::Watch(const std::stop_token& stop) {
  while (SleepFor(patience_ / 10, stop)) {
    {
      const std::lock_guard lock(mutex_);
      const Clock::time_point now = Clock::now();
      const bool is_told = warned_ && (counts_.size() == told_ || now - told_at_ < patience_);
      if (is_told || now - last_frame_ < wait_) continue;
      warned_ = true;
      told_at_ = now;
    }
    Warn(stop);
  }
}

void SilenceWatch::Warn(const std::stop_token& stop) {
  std::optional<Survey> heard;
  std::string text;
  try {
    heard.emplace(url_, stop);
  } catch (const std::exception& e) {  // also of a machine without memory or threads left
    text = std::string("what is waited for does not come, and nothing can be heard: ") + e.what();
  }
  if (stop.stop_requested()) return;  // it did not listen long enough to say what is missing
  const std::lock_guard lock(mutex_);
  if (!warned_) return;  // a frame has come meanwhile
  told_ = counts_.size();
  if (heard) text = SilenceText(needed_, counts_, heard->whole, heard->begun);
  monitor_.Warn(text);
  monitor_.HoldWarning(text);
  warnings_.push_back(std::move(text));
}

void DuplicateWatch::Heard(const StageStatus& status) {
  ForgetSilentOnes();
  const StageStatus own = monitor_.Snapshot();
  if (status.stage != own.stage || (status.pid == own.pid && status.host == own.host)) return;
  const std::pair name(status.host, status.pid);
  const auto known = twins_.find(name);
  if (status.state == StageStatus::State::kStopped) {
    if (known == twins_.end()) return;
    monitor_.Resolve(known->second.warning);
    twins_.erase(known);
    return;
  }
  if (known != twins_.end()) {
    known->second.heard = now_();
    return;
  }
  if (twins_.size() == kMaxTwins) return;
  const std::string text = "another sprout-" + status.stage + " works on these channels, process " +
                           std::to_string(status.pid) + " on " + status.host +
                           ": stop one of the two, or give it another --channel-prefix";
  twins_[name] = {text, now_()};
  monitor_.Warn(text);
  monitor_.HoldWarning(text);
}

void DuplicateWatch::ForgetSilentOnes() {
  std::erase_if(twins_, [&](const auto& entry) {
    const Twin& twin = entry.second;
    if (now_() - twin.heard < kSilentFor) return false;
    monitor_.Resolve(twin.warning);
    return true;
  });
}

}  // namespace sprout
