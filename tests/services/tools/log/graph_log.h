#pragma once

#include <gmock/gmock.h>

#include <string>
#include <vector>

#include "common/bus/channels.h"
#include "common/messages/message_type.h"
#include "services/tools/log/program.h"
#include "tests/common/app/run_main.h"
#include "tests/common/core/even_prior.h"
#include "tests/common/logfile/sample_log.h"
#include "tests/common/messages/examples.h"

namespace sprout::log {

inline const cv::Size kLogImageSize(32, 24);

inline FrameId LogFrameId(int64_t seq) {
  return {.utime = 1'700'000'000'000'000 + 100'000 * seq, .seq = seq, .rig_id = "cafe"};
}

inline sprout::Rig LogRig() {
  sprout::Rig rig = examples::Rig();
  rig.pair.width = kLogImageSize.width;
  rig.pair.height = kLogImageSize.height;
  rig.pair.cx = 16.5;
  rig.pair.cx_right = 6.75;
  rig.pair.cy = 12.25;
  rig.pair.focal_px = 50;
  return rig;
}

/// A slanted plane with a hole, another one each frame.
inline DisparityImage LogDisparity(int64_t seq) {
  DisparityImage disparity(kLogImageSize);
  for (int v = 0; v < disparity.height(); ++v) {
    for (int u = 4; u < disparity.width(); ++u) {
      disparity.counts()(v, u) = static_cast<int16_t>(320 + 8 * u + 32 * seq);
    }
  }
  return disparity;
}

inline PriorMap LogPrior(int64_t seq) { return EvenPrior(LogDisparity(seq), 1); }

inline PartValue LogValue(Part part, int64_t seq) {
  const auto grey = static_cast<double>(10 * seq % 200);
  switch (TypeOf(part)) {
    case MessageType::kImage:
      return part == Part::kLeft ? cv::Mat(kLogImageSize, CV_8UC3, cv::Scalar(grey, 100, 200))
                                 : cv::Mat(kLogImageSize, CV_8UC1, cv::Scalar(grey));
    case MessageType::kTof:
      return examples::Tof(/*amplitude=*/true);
    case MessageType::kRig:
      return LogRig();
    case MessageType::kSeeds:
      return SeedSet{.seeds = {{10, 5, 2}, {20, 9, 9}}, .raw = 2};
    case MessageType::kPrior:
      return LogPrior(seq);
    case MessageType::kDepth:
      return examples::Depth();
    case MessageType::kCloud:
      return examples::Cloud();
    case MessageType::kMotion:
      return examples::Motion();
    case MessageType::kDepthCounts:
      return examples::Counts();
    case MessageType::kTofZones:
      return examples::Zones();
    case MessageType::kDisparity:
    case MessageType::kStatus:
    case MessageType::kProcess:
    case MessageType::kRigChange:
      break;
  }
  return LogDisparity(seq);
}

inline Event PartEvent(Part part, int64_t seq, const PartValue& value,
                       DisparityEncoding encoding = DisparityEncoding::kRawInt16) {
  Event event;
  event.utime = LogFrameId(seq).utime + 1000 + 10 * static_cast<int64_t>(part);
  event.channel = ChannelOf(part);
  event.data = EncodePart(LogFrameId(seq), part, value, encoding);
  return event;
}

inline Event PartEvent(Part part, int64_t seq) { return PartEvent(part, seq, LogValue(part, seq)); }

inline Event StatusEvent(int64_t seq) {
  StageStatus status = examples::Status();
  status.newest_frame = LogFrameId(seq);
  Event event;
  event.utime = LogFrameId(seq).utime;
  event.channel = kStatusChannel;
  event.data = EncodeStatus(status);
  return event;
}

/// What a running graph leaves behind: all parts but the unfilled map, the calibration with frames
/// 1, 11, ..., and a status each frame.
inline std::vector<Event> GraphEvents(int frames) {
  std::vector<Event> events;
  for (int seq = 0; seq < frames; ++seq) {
    events.push_back(StatusEvent(seq));
    for (const Part part :
         {Part::kLeft, Part::kRight, Part::kTof, Part::kSeeds, Part::kPrior, Part::kDisparity}) {
      events.push_back(PartEvent(part, seq));
    }
    if (seq % 10 == 1) events.push_back(PartEvent(Part::kRig, seq));
  }
  return events;
}

inline Event& EventOf(std::vector<Event>& events, Part part, int64_t seq) {
  for (Event& event : events) {
    if (event.channel == ChannelOf(part) && event.utime == PartEvent(part, seq).utime) return event;
  }
  throw std::out_of_range("no such event");
}

inline void Erase(std::vector<Event>& events, Part part, int64_t seq) {
  const Event& event = EventOf(events, part, seq);
  events.erase(events.begin() + (&event - events.data()));
}

inline MainOutcome RunLog(std::vector<std::string> words) {
  words.insert(words.begin(), "sprout-log");
  return RunMain(words, LogMain);
}

/// What a run writes to stdout that ends with this exit code.
inline std::string OutOf(const std::vector<std::string>& words, int exit_code = 0) {
  const MainOutcome outcome = RunLog(words);
  EXPECT_EQ(outcome.exit_code, exit_code) << outcome.err;
  return outcome.out;
}

class LogFolder {
 public:
  /// Path of a file, be it there or not.
  std::string File(const char* name) const { return folder_ / name; }

  /// Writes the events as a log.
  std::string Write(const char* name, std::vector<Event> events) const {
    WriteBytes(folder_ / name, MakeLog(events));
    return File(name);
  }

  std::ptrdiff_t CountEntries() const { return folder_.CountEntries(); }

 private:
  TemporaryDirectory folder_;
};

class TestWithLogs : public ::testing::Test {
 protected:
  const LogFolder folder_;
};

/// Exit code 2, one line that holds `reason`, nothing on stdout.
inline void ExpectRefused(const std::vector<std::string>& arguments, const std::string& reason) {
  ExpectRefused(RunLog(arguments), 2, "sprout-log", reason);
}

/// Times and contents, without what writing a log adds.
inline std::vector<std::tuple<int64_t, std::string, Bytes>> Contents(
    const std::vector<Event>& events) {
  std::vector<std::tuple<int64_t, std::string, Bytes>> contents;
  for (const Event& event : events) {
    contents.emplace_back(event.utime, event.channel, event.data);
  }
  return contents;
}

}  // namespace sprout::log
