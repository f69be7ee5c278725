#include "services/capture/log_feed.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <deque>
#include <map>

#include "common/bus/channels.h"
#include "common/bus/frame_joiner.h"
#include "common/logfile/log_error.h"
#include "common/logfile/log_reader.h"
#include "common/messages/codec.h"
#include "services/capture/raw_source.h"
#include "services/capture/source_feed.h"

namespace sprout::capture {
namespace {

constexpr Part kCaptured[] = {Part::kLeft, Part::kRight, Part::kTof, Part::kRig};

class LogFeed : public CaptureFeed {
 public:
  // Without `calibrated` there is no calibration, and none is looked for.
  LogFeed(const std::string& path, const std::string& prefix, bool calibrated, bool loop,
          StageMonitor& monitor)
      : path_(path), prefix_(prefix), calibrated_(calibrated), loop_(loop), monitor_(monitor) {
    if (calibrated_) calibration_ = FirstCalibration();
    Rewind();
    first_ = Read();
    if (!first_) throw NoFrame();
  }

  std::optional<CaptureMessages> Next(const std::stop_token& /*stop*/) override {
    if (first_) return std::exchange(first_, std::nullopt);
    std::optional<CaptureMessages> next = Read();
    if (!next && loop_) {
      Rewind();
      next = Read();
    }
    return next;
  }

  std::vector<uint8_t> Calibration() const override { return calibration_; }

  Timing timing() const override { return Timing::kRecorded; }

 private:
  // Part that an event carries; nothing for what capture does not send.
  std::optional<Part> PartOf(const LogEvent& event) const {
    for (const Part part : kCaptured) {
      const std::string_view channel = ChannelOf(part);
      if (part == Part::kRig && !calibrated_) continue;
      if (event.channel.size() == prefix_.size() + channel.size() &&
          event.channel.starts_with(prefix_) && event.channel.ends_with(channel)) {
        return part;
      }
    }
    return std::nullopt;
  }

  // Recorded once a second only, so the first frames of a log may come before it.
  std::vector<uint8_t> FirstCalibration() {
    LogReader reader(path_);
    LogEvent event;
    std::string refused;  // why the first one was
    while (reader.Next(event)) {
      ++channels_[std::string(event.channel)];
      if (PartOf(event) != Part::kRig) continue;
      const Result<DecodedPart> decoded = DecodePart(Part::kRig, event.data);
      if (decoded) return {event.data.begin(), event.data.end()};
      if (refused.empty()) refused = decoded.error().text;
    }
    const std::string channel = prefix_ + std::string(ChannelOf(Part::kRig));
    const std::string what = refused.empty() ? "no " + channel + " in it"
                                             : "no usable " + channel + " in it (" + refused + ")";
    throw ConfigError("capture.source = log:" + path_ + ": " + what + "; it has " + ChannelText());
  }

  void Rewind() {
    reader_ = std::make_unique<LogReader>(path_);
    joiner_.emplace(PartSet{Part::kLeft, Part::kRight, Part::kTof});
    if (calibrated_) {
      Result<DecodedPart> rig = DecodePart(Part::kRig, calibration_);
      joiner_->Add(rig->id, Part::kRig, std::move(rig->value));
    }
    pending_.clear();
    channels_.clear();
  }

  std::optional<CaptureMessages> Read() {
    LogEvent event;
    while (reader_->Next(event)) {
      ++channels_[std::string(event.channel)];
      const std::optional<Part> part = PartOf(event);
      if (!part) continue;
      const Result<FrameId> id = DecodeFrameId(event.data);
      Result<DecodedPart> decoded =
          DecodePart(*part, event.data, id ? joiner_->ImageSizeOf(*id) : std::nullopt);
      if (!decoded) {
        monitor_.BadMessage(event.channel, decoded.error().text);
      } else if (part == Part::kRig) {
        joiner_->Add(decoded->id, Part::kRig, std::move(decoded->value));
        calibration_.assign(event.data.begin(), event.data.end());
        calibration_is_new_ = true;
      } else {
        Keep(decoded->id, *part, event.data);
        const auto whole = joiner_->Add(decoded->id, *part, std::move(decoded->value));
        if (!whole.empty()) return TakePending(decoded->id);
      }
    }
    EndOfLog();
    return std::nullopt;
  }

  // Beside the joiner, which keeps values: the bytes. The same frames are pending in both.
  void Keep(const FrameId& id, Part part, std::span<const uint8_t> bytes) {
    std::erase_if(pending_,
                  [&](const CaptureMessages& frame) { return !joiner_->IsPending(frame.id); });
    auto found = std::find_if(pending_.begin(), pending_.end(),
                              [&](const CaptureMessages& frame) { return frame.id == id; });
    if (found == pending_.end()) {
      pending_.push_back({.id = id, .messages = {}});
      found = std::prev(pending_.end());
    }
    std::erase_if(found->messages, [&](const auto& message) { return message.first == part; });
    found->messages.emplace_back(part, std::vector<uint8_t>(bytes.begin(), bytes.end()));
  }

  // The whole frame, behind the calibration when one came with it; older ones stay unfinished.
  CaptureMessages TakePending(const FrameId& id) {
    while (pending_.front().id != id) pending_.pop_front();
    monitor_.SetJoinerCounts(joiner_->incomplete(), joiner_->sequence_gaps());
    CaptureMessages frame = std::move(pending_.front());
    pending_.pop_front();
    if (std::exchange(calibration_is_new_, false)) {
      frame.messages.emplace(frame.messages.begin(), Part::kRig, calibration_);
    }
    return frame;
  }

  void EndOfLog() {
    joiner_->DropPending();
    monitor_.SetJoinerCounts(joiner_->incomplete(), joiner_->sequence_gaps());
    for (const LogDamage& stretch : reader_->damage()) {
      spdlog::warn("{}: {} unreadable bytes at byte {}{}", path_, stretch.bytes, stretch.offset,
                   stretch.tail ? ": it ends inside an event" : ", skipped");
    }
  }

  std::string ChannelText() const {
    std::string text;
    for (const auto& [channel, count] : channels_) {
      text += (text.empty() ? "" : ", ") + channel + " (" + std::to_string(count) + ")";
    }
    return text.empty() ? "no events" : text;
  }

  ConfigError NoFrame() const {
    return ConfigError("capture.source = log:" + path_ + ": no whole frame on " + prefix_ +
                       "SPROUT_LEFT, SPROUT_RIGHT and SPROUT_TOF in it; it has " + ChannelText());
  }

  std::string path_;
  std::string prefix_;
  bool calibrated_;
  bool loop_;
  StageMonitor& monitor_;
  std::map<std::string, int64_t> channels_;  // what was met
  std::vector<uint8_t> calibration_;         // newest
  bool calibration_is_new_ = false;
  std::unique_ptr<LogReader> reader_;
  std::optional<FrameJoiner> joiner_;
  std::deque<CaptureMessages> pending_;  // unfinished, in order of arrival
  std::optional<CaptureMessages> first_;
};

class RawLogFeed : public CaptureFeed {
 public:
  RawLogFeed(std::unique_ptr<CaptureFeed> log, const Rectifier& rectifier, StageMonitor& monitor)
      : log_(std::move(log)),
        rectifier_(rectifier),
        rig_id_(RigId(rectifier.rig())),
        monitor_(monitor) {}

  std::optional<CaptureMessages> Next(const std::stop_token& stop) override {
    while (const std::optional<CaptureMessages> raw = log_->Next(stop)) {
      Result<datasets::CapturedFrame> frame = RectifyFrame(rectifier_, Decoded(*raw));
      newest_ = {raw->id.utime, raw->id.seq, rig_id_};
      if (frame) return Encoded(newest_, *frame);
      monitor_.FrameFailed(newest_, frame.error().text);
    }
    return std::nullopt;
  }

  std::vector<uint8_t> Calibration() const override {
    const FrameId id{newest_.utime, std::max<int64_t>(newest_.seq, 0), rig_id_};
    return EncodePart(id, Part::kRig, rectifier_.rig(), DisparityEncoding::kRawInt16);
  }

  Timing timing() const override { return Timing::kRecorded; }

 private:
  // The log's feed has decoded every message once, so each of them can be.
  static datasets::CapturedFrame Decoded(const CaptureMessages& raw) {
    datasets::CapturedFrame frame;
    for (const auto& [part, bytes] : raw.messages) {
      const PartValue value = DecodePart(part, bytes)->value;
      if (part == Part::kLeft) frame.left = std::get<cv::Mat>(value);
      if (part == Part::kRight) frame.right = std::get<cv::Mat>(value);
      if (part == Part::kTof) frame.tof = std::get<TofImage>(value);
    }
    return frame;
  }

  std::unique_ptr<CaptureFeed> log_;
  Rectifier rectifier_;
  std::string rig_id_;
  StageMonitor& monitor_;
  FrameId newest_;
};

std::unique_ptr<CaptureFeed> Open(const std::string& path, const std::string& prefix,
                                  bool calibrated, bool loop, StageMonitor& monitor) {
  try {
    return std::make_unique<LogFeed>(path, prefix, calibrated, loop, monitor);
  } catch (const LogError& e) {
    throw ConfigError(std::string("capture.source = log:") + e.what());
  }
}

}  // namespace

std::unique_ptr<CaptureFeed> OpenLogFeed(const std::string& path, const std::string& prefix,
                                         bool loop, StageMonitor& monitor) {
  return Open(path, prefix, /*calibrated=*/true, loop, monitor);
}

std::unique_ptr<CaptureFeed> OpenRawLogFeed(const std::string& path, const std::string& prefix,
                                            const Rectifier& rectifier, bool loop,
                                            StageMonitor& monitor) {
  return std::make_unique<RawLogFeed>(
      Open(path, prefix + std::string(kRawPrefix), /*calibrated=*/false, loop, monitor), rectifier,
      monitor);
}

}  // namespace sprout::capture
