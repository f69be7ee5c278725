// Sends the frames of a log again and again, each as a new one, at a rate of its own: a graph as
// fast as one likes, without what computing the frames would cost.
#include <chrono>
#include <cstdint>
#include <iostream>
#include <string>
#include <thread>
#include <vector>

#include "common/app/stage_monitor.h"
#include "common/bus/channels.h"
#include "common/bus/publisher.h"
#include "common/frames/frame_index.h"
#include "common/logfile/log_reader.h"

namespace sprout::view {
namespace {

struct Message {
  std::string channel;
  std::vector<uint8_t> bytes;
};

// In every type of Sprout the header follows the fingerprint: utime, seq, ..., big-endian.
void SetHeader(std::vector<uint8_t>& bytes, int64_t utime, int64_t seq) {
  for (size_t i = 0; i < 8; ++i) {
    bytes[8 + i] = static_cast<uint8_t>(utime >> (56 - 8 * i));
    bytes[16 + i] = static_cast<uint8_t>(seq >> (56 - 8 * i));
  }
}

std::vector<std::vector<Message>> ReadFrames(const std::string& path) {
  FrameIndex index({.look_back = FrameChoice::kWholeLog});
  LogReader reader(path);
  for (LogEvent event; reader.Next(event);) index.Add(event);
  EventFetcher fetcher(path);
  std::vector<std::vector<Message>> list;
  for (size_t i = 0; i < index.frames().size(); ++i) {
    const IndexedFrame frame = index.At(i);
    std::vector<Message>& messages = list.emplace_back();
    for (const Part part : kAllParts) {
      if (!frame.Has(part)) continue;
      const LogEvent event = fetcher.Fetch(frame.offset(part));
      messages.push_back({std::string(event.channel), {event.data.begin(), event.data.end()}});
    }
  }
  return list;
}

int Main(const std::string& path, double rate_hz, double seconds) {
  auto frames = ReadFrames(path);
  Publisher publisher(kDefaultLcmUrl, "");
  const auto period = std::chrono::duration<double>(1 / rate_hz);
  const auto start = std::chrono::steady_clock::now();
  const auto count = static_cast<int64_t>(rate_hz * seconds);
  for (int64_t seq = 0; seq < count; ++seq) {
    std::this_thread::sleep_until(start + seq * period);
    const int64_t utime = NowUtime();
    for (Message& message : frames[static_cast<size_t>(seq) % frames.size()]) {
      SetHeader(message.bytes, utime, seq);
      if (!publisher.Publish(message.channel, message.bytes)) return 1;
    }
  }
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
  std::cout << count << " frames at " << static_cast<double>(count) / took.count() << " Hz\n";
  return 0;
}

}  // namespace
}  // namespace sprout::view

int main(int argc, char** argv) {
  if (argc != 4) {
    std::cerr << "usage: play_frames LOG RATE_HZ SECONDS\n";
    return 2;
  }
  return sprout::view::Main(argv[1], std::stod(argv[2]), std::stod(argv[3]));
}
