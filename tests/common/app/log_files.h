#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/logfile/log_reader.h"
#include "common/logfile/log_writer.h"
#include "tests/common/messages/examples.h"

namespace sprout {

/// An event of a log, apart from the log.
struct TestEvent {
  int64_t utime = 0;
  std::string channel;
  std::vector<uint8_t> data;

  bool operator==(const TestEvent&) const = default;
};

inline void WriteLog(const std::string& path, const std::vector<TestEvent>& events) {
  LogWriter writer(path);
  for (const TestEvent& event : events) writer.Write(event.utime, event.channel, event.data);
  writer.Close();
}

inline std::vector<TestEvent> ReadLog(const std::string& path) {
  std::vector<TestEvent> events;
  LogReader reader(path);
  LogEvent event;
  while (reader.Next(event)) {
    events.push_back(
        {event.utime, std::string(event.channel), {event.data.begin(), event.data.end()}});
  }
  return events;
}

/// Frame `seq` of a capture that takes one every 100 ms.
inline FrameId TestId(int64_t seq) {
  return {.utime = 1'000'000 + 100'000 * seq, .seq = seq, .rig_id = RigId(examples::Rig())};
}

/// A part of frame `seq`, recorded `delay` µs after its capture, on a channel of its own.
inline TestEvent EventOf(int64_t seq, Part part, const PartValue& value, int64_t delay,
                         const std::string& channel) {
  return {TestId(seq).utime + delay, channel, EncodePart(TestId(seq), part, value)};
}

/// LEFT of frame `seq`; every grey value is `grey`.
inline TestEvent LeftEvent(int64_t seq, int grey, const std::string& prefix = "") {
  return EventOf(seq, Part::kLeft, cv::Mat(2, 3, CV_8UC1, cv::Scalar(grey)), 1000,
                 prefix + "SPROUT_LEFT");
}

inline TestEvent RightEvent(int64_t seq, const std::string& prefix = "") {
  return EventOf(seq, Part::kRight, cv::Mat(2, 3, CV_8UC1, cv::Scalar(0)), 1500,
                 prefix + "SPROUT_RIGHT");
}

inline TestEvent TofEvent(int64_t seq, const std::string& prefix = "") {
  return EventOf(seq, Part::kTof, examples::Tof(false), 2000, prefix + "SPROUT_TOF");
}

inline TestEvent SeedsEvent(int64_t seq, int raw, const std::string& prefix = "") {
  return EventOf(seq, Part::kSeeds, SeedSet{.seeds = {}, .raw = raw}, 3000,
                 prefix + "SPROUT_SEEDS");
}

inline TestEvent RigEvent(int64_t seq, const std::string& prefix = "") {
  return EventOf(seq, Part::kRig, examples::Rig(), 500, prefix + "SPROUT_RIG");
}

}  // namespace sprout
