#include <fmt/core.h>

#include <chrono>
#include <iostream>
#include <mutex>
#include <optional>
#include <stdexcept>

#include "common/app/progress.h"
#include "common/bus/lcm_url.h"
#include "common/bus/mailbox.h"
#include "common/bus/receiver.h"
#include "common/config/config_error.h"
#include "common/core/signal_watcher.h"
#include "common/frames/frame_joiner.h"
#include "services/tools/quality/sources.h"

namespace sprout::quality {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::seconds kRefresh{1};
constexpr std::chrono::seconds kPatience{30};  // with --once

// Frames on the bus that have a disparity map and a calibration, and standard deviations once such
// are heard.
class MapFrames {
 public:
  explicit MapFrames(const LiveOptions& options)
      : receiver_(options.lcm_url, options.prefix, Channels(),
                  [this](std::string_view channel, std::span<const uint8_t> bytes) {
                    OnMessage(channel, bytes);
                  }) {}

  std::optional<Frame> TakeWithin(std::chrono::milliseconds time, const std::stop_token& stop) {
    std::optional<Frame> frame = mailbox_.TakeWithin(time, stop);
    if (!frame) ExpectSigma(false);  // whoever sent it may have ended
    return frame;
  }

  /// Why the last message that could not be used could not; empty: all could.
  std::string complaint() const {
    const std::lock_guard lock(mutex_);
    return complaint_;
  }

  int64_t skipped() const {
    const std::lock_guard lock(mutex_);
    return skipped_;
  }

 private:
  static std::vector<std::string_view> Channels() {
    return {ChannelOf(Part::kDisparity), ChannelOf(Part::kSigma), ChannelOf(Part::kRig)};
  }

  static FrameJoiner JoinerFor(bool with_sigma) {
    PartSet needed = {Part::kDisparity, Part::kRig};
    if (with_sigma) needed.Add(Part::kSigma);
    return FrameJoiner(needed);
  }

  // What is pending is lost, and the calibration, which comes again within a second.
  void ExpectSigma(bool expected) {
    const std::lock_guard lock(mutex_);
    if (expected == with_sigma_) return;
    with_sigma_ = expected;
    joiner_ = JoinerFor(expected);
  }

  void OnMessage(std::string_view channel, std::span<const uint8_t> bytes) {
    const std::optional<Part> part = PartOf(channel);
    if (!part) return;
    if (part == Part::kSigma) ExpectSigma(true);
    const std::lock_guard lock(mutex_);
    Result<std::vector<Frame>> frames = joiner_.AddMessage(*part, bytes);
    if (!frames) {
      complaint_ = fmt::format("{}: {}", channel, frames.error().text);
      return;
    }
    for (Frame& frame : *frames) skipped_ += mailbox_.Put(std::move(frame)) ? 1 : 0;
  }

  mutable std::mutex mutex_;
  bool with_sigma_ = false;
  FrameJoiner joiner_ = JoinerFor(false);
  std::string complaint_;
  int64_t skipped_ = 0;
  Mailbox<Frame> mailbox_;
  Receiver receiver_;  // last: stops before the rest is destroyed
};

std::runtime_error NoMap(const MapFrames& frames, const std::string& when) {
  std::string text = "no disparity map with a calibration came" + when +
                     " (SPROUT_DISPARITY, SPROUT_RIG): is the graph running?";
  if (!frames.complaint().empty())
    text += " The last message that cannot be read: " + frames.complaint();
  return std::runtime_error(text);
}

}  // namespace

void MeasureGraph(const LiveOptions& options, Measurement& measurement,
                  const std::function<void()>& refresh) {
  if (const auto error = LcmUrlError(options.lcm_url)) throw ConfigError("--lcm-url: " + *error);
  const SignalWatcher signals;
  MapFrames frames(options);
  Progress progress(/*quiet=*/false);
  progress.Show("waiting for disparity maps");
  Clock::time_point shown = Clock::now();
  Clock::time_point heard = shown;
  bool is_new = false;
  while (!signals.token().stop_requested()) {
    if (auto frame = frames.TakeWithin(kRefresh, signals.token())) {
      AddFrame(*frame, measurement);
      heard = Clock::now();
      is_new = true;
    }
    if (options.once && !measurement.empty() &&
        measurement.meter().frames() == measurement.settings().count) {
      break;
    }
    const Clock::time_point now = Clock::now();
    if (options.once && now - heard > kPatience) {
      throw NoMap(frames, fmt::format(" in {} s", kPatience.count()));
    }
    if (!is_new || now - shown < kRefresh) continue;
    progress.Clear();
    refresh();
    shown = now;
    is_new = false;
  }
  progress.Clear();
  if (measurement.empty()) throw NoMap(frames, "");
  if (!frames.complaint().empty()) std::cerr << "sprout-quality: " << frames.complaint() << "\n";
  if (frames.skipped() > 0) {
    std::cerr << "sprout-quality: " << frames.skipped()
              << " maps came faster than they were measured, and were left out\n";
  }
}

}  // namespace sprout::quality
