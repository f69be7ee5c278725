#include <algorithm>
#include <utility>

#include "common/bus/channels.h"
#include "common/frames/log_frames.h"
#include "common/logfile/log_error.h"
#include "common/logfile/log_reader.h"
#include "common/messages/codec.h"
#include "common/messages/packed.h"
#include "services/capture/raw_source.h"
#include "services/capture/source_feed.h"

namespace sprout::capture {
namespace {

class LogFeed : public CaptureFeed {
 public:
  // If `calibrated` is false the log has no calibration, and none is looked for.
  LogFeed(const std::string& path, const std::string& prefix, bool calibrated, bool loop,
          StageMonitor& monitor)
      : path_(path),
        prefix_(prefix),
        calibrated_(calibrated),
        loop_(loop),
        monitor_(monitor),
        fetcher_(path) {
    if (calibrated_) captured_.Add(Part::kRig);
    if (HasZones()) captured_.Add(Part::kTofZones);
    Rewind();
    first_ = Read();
    if (!first_) {
      throw Unusable("no whole frame on " + prefix_ +
                         "SPROUT_LEFT, SPROUT_RIGHT and SPROUT_TOF in it" +
                         (calibrated_ ? " with the rig_id of a SPROUT_RIG" : ""),
                     frames_->channels());
    }
  }

  std::optional<CaptureMessages> Next(const std::stop_token& /*stop*/) override {
    if (first_) return std::exchange(first_, std::nullopt);
    std::optional<CaptureMessages> next = Read();
    if (!next && loop_) {
      Rewind();
      ++rounds_;
      next = Read();
    }
    return next;
  }

  std::vector<uint8_t> Calibration() const override { return calibration_; }

  Timing timing() const override { return Timing::kRecorded; }

  bool lacks_something() const override { return lacks_something_; }

  /// How often the log has begun again.
  int64_t rounds() const { return rounds_; }

 private:
  // Searches the whole log: a calibration comes once a second, so frames may come before the first.
  std::vector<uint8_t> FirstCalibration() const {
    LogReader reader(path_);
    ChannelCounts channels;
    std::string refused;  // why the first one cannot be used
    for (LogEvent event; reader.Next(event);) {
      channels.Add(event.channel);
      if (PartOf(event.channel, prefix_) != Part::kRig) continue;
      const Result<DecodedPart> decoded = DecodePart(Part::kRig, event.data);
      if (decoded) return {event.data.begin(), event.data.end()};
      if (refused.empty()) refused = decoded.error().text;
    }
    const std::string channel = prefix_ + std::string(ChannelOf(Part::kRig));
    const std::string raw = prefix_ + std::string(kRawPrefix) + std::string(ChannelOf(Part::kLeft));
    const bool is_raw = channels.Has(raw);
    throw Unusable(refused.empty()
                       ? "no " + channel + " in it" +
                             (is_raw ? ", its images are raw, ?rig=FILE rectifies them" : "")
                       : "no usable " + channel + " in it (" + refused + ")",
                   channels);
  }

  // Capture sends TOF_ZONES before TOF. A log may begin between the two, so two scans are awaited.
  bool HasZones() const {
    LogReader reader(path_);
    int scans = 0;
    for (LogEvent event; scans < 2 && reader.Next(event);) {
      const std::optional<Part> part = PartOf(event.channel, prefix_);
      if (part == Part::kTofZones) return true;
      scans += part == Part::kTof;
    }
    return false;
  }

  ConfigError Unusable(const std::string& what, const ChannelCounts& channels) const {
    return ConfigError("capture.source = log:" + path_ + ": " + what + "; it has " +
                       channels.Text());
  }

  void Rewind() {
    if (frames_) {
      incomplete_ += frames_->joiner().incomplete();
      sequence_gaps_ += frames_->joiner().sequence_gaps();
    }
    frames_.emplace(path_, prefix_, captured_, [this](const LogEvent& event, const auto& why) {
      lacks_something_ = true;
      monitor_.BadMessage(event.channel, why);
    });
    if (calibrated_) frames_->AddRig(calibration_ = FirstCalibration());
    rig_.reset();
  }

  std::optional<CaptureMessages> Read() {
    const std::optional<WholeFrame> next = frames_->Next();
    monitor_.SetJoinerCounts(incomplete_ + frames_->joiner().incomplete(),
                             sequence_gaps_ + frames_->joiner().sequence_gaps());
    if (calibrated_ && rig_ != frames_->newest_rig()) {
      rig_ = frames_->newest_rig();
      calibration_ = Bytes(*rig_);
      calibration_is_new_ = true;
    }
    if (next) return MessagesOf(next->places);
    for (const LogDamage& stretch : frames_->log().damage()) {
      lacks_something_ = true;
      monitor_.Failure(path_ + ": " + SkippedText(stretch));
    }
    return std::nullopt;
  }

  // The frame's messages in the order of the log, behind the calibration when one came with them.
  CaptureMessages MessagesOf(const IndexedFrame& places) {
    CaptureMessages messages{.id = places.id, .messages = {}};
    if (std::exchange(calibration_is_new_, false)) {
      messages.messages.emplace_back(Part::kRig, calibration_);
    }
    std::vector<std::pair<int64_t, Part>> in_order;
    for (const Part part : kAllParts) {
      if (places.Has(part)) in_order.emplace_back(places.offset(part), part);
    }
    std::ranges::sort(in_order);
    for (const auto& [offset, part] : in_order) messages.messages.emplace_back(part, Bytes(offset));
    return messages;
  }

  std::vector<uint8_t> Bytes(int64_t offset) {
    const LogEvent event = fetcher_.Fetch(offset);
    if (IsPacked(event.data)) {
      // Listeners may not know packed messages. This one was decoded before, so it can be unpacked.
      if (Result<std::vector<uint8_t>> message = Unpack(event.data)) return *std::move(message);
    }
    return {event.data.begin(), event.data.end()};
  }

  std::string path_;
  std::string prefix_;
  bool calibrated_;
  bool loop_;
  PartSet captured_{Part::kLeft, Part::kRight, Part::kTof};
  StageMonitor& monitor_;
  EventFetcher fetcher_;
  std::vector<uint8_t> calibration_;  // newest
  std::optional<int64_t> rig_;        // its offset in the log
  bool calibration_is_new_ = false;
  std::optional<WholeFrames> frames_;
  int64_t incomplete_ = 0;  // frames of the rounds before
  int64_t sequence_gaps_ = 0;
  std::optional<CaptureMessages> first_;
  int64_t rounds_ = 0;
  bool lacks_something_ = false;
};

class RawLogFeed : public CaptureFeed {
 public:
  RawLogFeed(std::unique_ptr<LogFeed> log, std::shared_ptr<CurrentRig> rig, StageMonitor& monitor)
      : log_(std::move(log)), current_(std::move(rig)), used_(current_->Get()), monitor_(monitor) {}

  std::optional<CaptureMessages> Next(const std::stop_token& stop) override {
    while (!stop.stop_requested()) {
      const std::optional<CaptureMessages> raw = log_->Next(stop);
      // The end, or a whole round without a frame that could be given.
      if (!raw || log_->rounds() > round_ + 1) return std::nullopt;
      const RigInUsePtr rig = current_->Get();
      scenes::CapturedFrame frame = Decoded(*raw);
      const Result<void> rectified = rig->rectifier.Rectify(frame.left, frame.right, frame.tof);
      newest_ = {raw->id.utime, raw->id.seq, rig->rig_id};
      if (!rectified) {
        monitor_.FrameFailed(newest_, rectified.error().text);
        continue;
      }
      round_ = log_->rounds();
      const bool is_new = rig != std::exchange(used_, rig);
      CaptureMessages messages = Encoded(newest_, frame);
      return is_new ? BehindCalibration(Calibration(), std::move(messages)) : messages;
    }
    return std::nullopt;
  }

  std::vector<uint8_t> Calibration() const override {
    const FrameId id{newest_.utime, std::max<int64_t>(newest_.seq, 0), used_->rig_id};
    return EncodePart(id, Part::kRig, used_->rectifier.rig());
  }

  Timing timing() const override { return Timing::kRecorded; }

  bool lacks_something() const override { return log_->lacks_something(); }

  std::shared_ptr<CurrentRig> current_rig() const override { return current_; }

 private:
  // The log's feed has decoded every message once, so each of them can be.
  static scenes::CapturedFrame Decoded(const CaptureMessages& raw) {
    scenes::CapturedFrame frame;
    for (const auto& [part, bytes] : raw.messages) {
      const PartValue value = DecodePart(part, bytes)->value;
      if (part == Part::kLeft) frame.left = std::get<cv::Mat>(value);
      if (part == Part::kRight) frame.right = std::get<cv::Mat>(value);
      if (part == Part::kTof) frame.tof = std::get<TofImage>(value);
    }
    return frame;
  }

  std::unique_ptr<LogFeed> log_;
  std::shared_ptr<CurrentRig> current_;
  RigInUsePtr used_;  // for the newest frame that was sent
  StageMonitor& monitor_;
  FrameId newest_;
  int64_t round_ = 0;  // of the log, in which a frame was given last
};

std::unique_ptr<LogFeed> Open(const std::string& path, const std::string& prefix, bool calibrated,
                              bool loop, StageMonitor& monitor) {
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
                                            std::shared_ptr<CurrentRig> rig, bool loop,
                                            StageMonitor& monitor) {
  return std::make_unique<RawLogFeed>(
      Open(path, prefix + std::string(kRawPrefix), /*calibrated=*/false, loop, monitor),
      std::move(rig), monitor);
}

}  // namespace sprout::capture
