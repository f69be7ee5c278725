#include "common/app/replay.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <utility>

#include "common/app/answer.h"
#include "common/app/frame_assembler.h"
#include "common/app/log.h"
#include "common/app/progress.h"
#include "common/app/replay_input.h"
#include "common/app/stage_monitor.h"
#include "common/app/status_reporter.h"
#include "common/bus/channels.h"
#include "common/core/digest.h"
#include "common/core/joined.h"
#include "common/logfile/log_error.h"
#include "common/logfile/log_writer.h"
#include "common/messages/codec.h"
#include "common/messages/message_type.h"

namespace sprout {
namespace {

namespace fs = std::filesystem;

using Clock = StageMonitor::Clock;

// Recorded configurations that are compared; a log can hold any number.
constexpr size_t kMaxCompared = 16;

constexpr std::chrono::milliseconds kProgressPeriod{200};

// Calibrations whose names are kept; a log can hold any number.
constexpr size_t kMaxRigs = 64;

void RequireOtherFile(const std::string& log, const std::string& record) {
  std::error_code ignored;
  if (fs::equivalent(log, record, ignored)) {
    throw ConfigError("--record " + record + ": would overwrite --replay " + log +
                      "; allowed: another file");
  }
}

ReplayInput OpenInput(const std::vector<std::string>& logs, const std::string& prefix,
                      PartSet inputs) {
  std::set<std::string, std::less<>> ordering;
  for (const Part part : kAllParts) {
    if (inputs.Has(part)) ordering.insert(prefix + std::string(ChannelOf(part)));
  }
  try {
    return ReplayInput(logs, prefix + std::string(kProcessChannel), std::move(ordering));
  } catch (const LogError& e) {
    throw ConfigError(std::string("--replay ") + e.what());
  }
}

std::unique_ptr<LogWriter> OpenRecording(const std::string& record) {
  try {
    return std::make_unique<LogWriter>(record);
  } catch (const LogError& e) {
    throw ConfigError(std::string("--record ") + e.what());
  }
}

FrameRange WithWarmUp(FrameRange frames, int64_t warm_up) {
  frames.first = std::max<int64_t>(0, frames.first - warm_up);
  return frames;
}

class Replay {
 public:
  Replay(const ServiceContext& context, const ReplayOptions& options, StageAdapter& adapter)
      : context_(context),
        options_(options),
        adapter_(adapter),
        encoding_(EncodingOf(context.config.bus())),
        monitor_(context.stage, Digest(ConfigText(context.config))),
        assembler_(adapter.Inputs(), monitor_, kReplayMaxPending, adapter.OptionalInputs()),
        needed_(WithWarmUp(options.frames, adapter.WarmUpFrames())),
        input_(OpenInput(options.logs, context.prefix, adapter.Inputs())),
        recording_(OpenRecording(options.record)),
        progress_(/*quiet=*/false) {
    monitor_.SetReplay();
  }

  int Run() {
    if (adapter_.Inputs().Has(Part::kRig)) AddFirstCalibration();
    LogEvent event;
    while (!context_.stop.stop_requested() && input_.Next(event)) {
      Take(event);
      ShowProgress();
    }
    AnswerAll(assembler_.Finish(), last_utime_);
    progress_.Clear();
    const bool stopped = context_.stop.stop_requested();
    if (!stopped) RequireFrames();
    recording_->Close();
    return Report(stopped);
  }

 private:
  std::string LoggedChannel(std::string_view channel) const {
    return context_.prefix + std::string(channel);
  }

  void AddFirstCalibration() {
    const std::string channel = LoggedChannel(ChannelOf(Part::kRig));
    ReplayInput look_ahead(options_.logs);
    LogEvent event;
    while (!context_.stop.stop_requested() && look_ahead.Next(event)) {
      if (event.channel != channel || !DecodePart(Part::kRig, event.data)) continue;
      assembler_.Add(ChannelOf(Part::kRig), event.data);
      return;
    }
  }

  // What the log was made with, before any answer. Its time is that of the first frame, whatever
  // else stands before it in the log, so that a part of a log has the time that the whole has.
  void WriteInfoOnce(int64_t utime) {
    if (std::exchange(info_written_, true)) return;
    recording_->Write(utime, LoggedChannel(kProcessChannel),
                      EncodeProcessInfo(ReplayProcessInfo(context_, std::max<int64_t>(utime, 0))));
  }

  void Take(const LogEvent& event) {
    if (!event.channel.starts_with(context_.prefix)) return;
    const std::string_view channel = event.channel.substr(context_.prefix.size());
    if (channel == kProcessChannel) return CompareWithRecorded(event.data);
    if (!IsWanted(channel, event.data)) return;
    last_utime_ = event.utime;
    AnswerAll(assembler_.Add(channel, event.data), event.utime);
  }

  // @param utime  of the event that completed the frames.
  void AnswerAll(const std::vector<Frame>& frames, int64_t utime) {
    for (const Frame& frame : frames) {
      if (!options_.frames.Has(frame.id.seq)) {
        ++warm_up_frames_;
        MakeAnswer(frame, adapter_, encoding_, monitor_);
        continue;
      }
      WriteInfoOnce(utime);
      const auto arrived = Clock::now();
      monitor_.FrameIn(/*skipped=*/false);
      const std::optional<Answer> answer = MakeAnswer(frame, adapter_, encoding_, monitor_);
      if (!answer) continue;
      for (const Answer::Message& message : answer->messages) {
        recording_->Write(utime, LoggedChannel(message.channel), message.bytes);
      }
      monitor_.FrameOut(frame.id, arrived, answer->degenerate, answer->tof_coverage);
    }
  }

  // Warns of each recorded configuration of this stage that is another one, once.
  void CompareWithRecorded(std::span<const uint8_t> bytes) {
    const Result<ProcessInfo> recorded = DecodeProcessInfo(bytes);
    if (!recorded) return monitor_.BadMessage(kProcessChannel, recorded.error().text);
    if (recorded->stage != context_.stage) return;
    if (compared_.size() == kMaxCompared || !compared_.insert(recorded->config_text).second) return;
    if (const auto change = ConfigChangeText(context_, *recorded)) {
      progress_.Clear();
      LogLine(LogLevel::kWarning, *change);
    }
  }

  // False for messages of frames out of range, which are then neither decoded nor missed.
  bool IsWanted(std::string_view channel, std::span<const uint8_t> bytes) {
    const std::optional<Part> part = PartOf(channel);
    if (!part || !adapter_.Inputs().Has(*part)) return true;
    const Result<FrameId> id = DecodeFrameId(bytes);
    if (part == Part::kRig) {
      if (id) NoteRig(id->rig_id, rigs_there_);
      return true;
    }
    // Decoding counts what names no frame as a bad message.
    if (TypeOf(bytes) != TypeOf(*part) || !id || id->seq < 0) return true;
    if (!seen_) seen_ = FrameRange{.first = id->seq, .last = id->seq};
    seen_->first = std::min(seen_->first, id->seq);
    seen_->last = std::max(seen_->last, id->seq);
    if (!needed_.Has(id->seq)) return false;
    NoteRig(id->rig_id, rigs_named_);
    return true;
  }

  static void NoteRig(const std::string& rig_id, std::set<std::string>& rigs) {
    if (rigs.size() < kMaxRigs) rigs.insert(rig_id);
  }

  // Calibrations that frames name and that no log has; empty when there are none.
  std::string MissingRigs() const {
    if (!adapter_.Inputs().Has(Part::kRig) || rigs_there_.size() == kMaxRigs) return "";
    std::vector<std::string> missing;
    std::ranges::set_difference(rigs_named_, rigs_there_, std::back_inserter(missing));
    if (missing.empty()) return "";
    return fmt::format("no {} with the rig_id of frames, '{}'; it has '{}'",
                       LoggedChannel(ChannelOf(Part::kRig)), Joined("', '", missing),
                       Joined("', '", rigs_there_));
  }

  void ShowProgress() {
    const auto now = Clock::now();
    if (now < next_progress_) return;
    next_progress_ = now + kProgressPeriod;
    const StageStatus status = monitor_.Snapshot();
    progress_.Show(fmt::format("{}: {:.0f} %, {} frames, {:.1f} frames/s", context_.stage,
                               100 * input_.progress(), status.frames_out, status.rate_hz));
  }

  // A run that had nothing to work on is a mistake, and the likely ones are named.
  void RequireFrames() const {
    const StageStatus status = monitor_.Snapshot();
    if (status.frames_in > 0) return;
    const std::string logs = Joined(", ", options_.logs);
    std::vector<std::string> missing;
    for (const std::string_view channel : assembler_.channels()) {
      const std::string name = LoggedChannel(channel);
      if (!input_.channels().Has(name)) missing.push_back(name);
    }
    if (!missing.empty()) {
      throw ConfigError(fmt::format("--replay {}: no {}; it has {}", logs, Joined(", ", missing),
                                    input_.channels().Text()));
    }
    if (seen_ && (seen_->first > options_.frames.last || seen_->last < options_.frames.first)) {
      throw ConfigError(fmt::format("--frames: none of them in {}; it has {}:{}", logs,
                                    seen_->first, seen_->last));
    }
    if (const std::string rigs = MissingRigs(); !rigs.empty()) {
      throw ConfigError(fmt::format("--replay {}: {}", logs, rigs));
    }
    throw ConfigError(fmt::format(
        "--replay {}: no frame is complete ({} lack a message, {} bad messages); it has {}", logs,
        status.frames_incomplete, status.bad_messages, input_.channels().Text()));
  }

  int Report(bool stopped) const {
    const StageStatus status = monitor_.Snapshot();
    const double seconds = std::chrono::duration<double>(Clock::now() - started_).count();
    std::cout << fmt::format(
        "{}: {}{} events; frames: {} in, {} out ({} degenerate), {} failed, {} incomplete, {} left "
        "out; {} bad messages, {} damaged bytes{}; {:.2f} s, {:.1f} frames/s\n",
        context_.stage, stopped ? "stopped after " : "", input_.events(), status.frames_in,
        status.frames_out, status.frames_degenerate, status.frames_failed, status.frames_incomplete,
        status.sequence_gaps, status.bad_messages, input_.damaged_bytes(),
        warm_up_frames_ > 0 ? fmt::format("; {} frames to warm up", warm_up_frames_) : "", seconds,
        static_cast<double>(status.frames_out) / seconds);
    const bool is_of_nothing =
        status.frames_out > 0 && status.frames_degenerate == status.frames_out;
    if (is_of_nothing) {
      LogLine(LogLevel::kError, "all {} frames are degenerate, the last error is: {}",
              status.frames_out, status.last_error);
    }
    if (const std::string rigs = MissingRigs(); !rigs.empty()) LogLine(LogLevel::kWarning, rigs);
    const std::vector<std::string> left_out = input_.LeftOut();
    for (const std::string& line : left_out) LogLine(LogLevel::kError, line);
    const bool whole = left_out.empty() && !stopped && !is_of_nothing &&
                       status.frames_failed == 0 && status.bad_messages == 0 &&
                       input_.damaged_bytes() == 0;
    return whole ? 0 : 1;
  }

  const ServiceContext& context_;
  const ReplayOptions& options_;
  StageAdapter& adapter_;
  DisparityEncoding encoding_;
  StageMonitor monitor_;
  FrameAssembler assembler_;
  FrameRange needed_;  // those wanted, and before them those to warm up
  int64_t warm_up_frames_ = 0;
  ReplayInput input_;
  std::unique_ptr<LogWriter> recording_;
  Progress progress_;
  bool info_written_ = false;
  int64_t last_utime_ = 0;            // of a message that a frame may need
  std::optional<FrameRange> seen_;    // from the smallest to the largest seq in the logs
  std::set<std::string> rigs_named_;  // rig_id of frames
  std::set<std::string> rigs_there_;
  std::set<std::string> compared_;  // recorded configurations of this stage
  Clock::time_point started_ = Clock::now();
  Clock::time_point next_progress_{};
};

}  // namespace

int RunReplay(const ServiceContext& context, const ReplayOptions& options, StageAdapter& adapter) {
  for (const std::string& log : options.logs) RequireOtherFile(log, options.record);
  return Replay(context, options, adapter).Run();
}

}  // namespace sprout
