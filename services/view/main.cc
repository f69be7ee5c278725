#include <fmt/core.h>

#include <chrono>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <functional>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string_view>
#include <utility>

#include "common/app/log.h"
#include "common/app/log_limiter.h"
#include "common/app/service.h"
#include "common/app/service_context.h"
#include "common/app/silence_watch.h"
#include "common/app/stage_monitor.h"
#include "common/app/status_reporter.h"
#include "common/app/version.h"
#include "common/bus/channels.h"
#include "common/bus/receiver.h"
#include "common/core/digest.h"
#include "common/core/sleep.h"
#include "common/frames/sequence_gaps.h"
#include "common/messages/codec.h"
#include "services/view/frame_encoder.h"
#include "services/view/frame_ring.h"
#include "services/view/http_handler.h"
#include "services/view/log_file.h"
#include "services/view/map_colors.h"
#include "services/view/server.h"
#include "services/view/status_history.h"

namespace sprout::view {
namespace {

// Receives all messages of the graph, and stores them in ring and history.
class BusListener {
 public:
  // @param changed  called on another thread when the ring has a newer frame; must be quick.
  // @throws BusError.
  BusListener(const ServiceContext& context, FrameRing& ring, StatusHistory& history,
              StageMonitor& monitor, std::function<void()> changed);

 private:
  void OnMessage(std::string_view channel, std::span<const uint8_t> bytes);
  void OnStatus(std::span<const uint8_t> bytes, StageMonitor::Clock::time_point now);
  void OnNewest(StageMonitor::Clock::time_point now);

  FrameRing& ring_;
  StatusHistory& history_;
  StageMonitor& monitor_;
  std::function<void()> changed_;
  SilenceWatch silence_;
  DuplicateWatch duplicates_;
  SequenceGaps gaps_;
  std::optional<int64_t> newest_key_;
  Receiver receiver_;  // last: stops before the rest is destroyed
};

BusListener::BusListener(const ServiceContext& context, FrameRing& ring, StatusHistory& history,
                         StageMonitor& monitor, std::function<void()> changed)
    : ring_(ring),
      history_(history),
      monitor_(monitor),
      changed_(std::move(changed)),
      // These two channels are needed to see anything; all others may be missing.
      silence_(context, {ChannelOf(Part::kLeft), ChannelOf(Part::kDisparity)}, monitor),
      duplicates_(monitor),
      receiver_(
          context.lcm_url, context.prefix, AllChannels(),
          [this](std::string_view channel, std::span<const uint8_t> bytes) {
            OnMessage(channel, bytes);
          },
          [this](std::string_view channel) { monitor_.MessageDropped(channel); }) {}

void BusListener::OnMessage(std::string_view channel, std::span<const uint8_t> bytes) {
  const auto now = StageMonitor::Clock::now();
  try {
    if (channel == kStatusChannel) OnStatus(bytes, now);
    silence_.Heard(channel);
    const Result<bool> changed = ring_.Add(channel, bytes, NowUtime(), now);
    if (!changed) return monitor_.BadMessage(channel, changed.error().text);
    if (*changed) OnNewest(now);
  } catch (const std::exception& e) {  // out of memory
    monitor_.BadMessage(channel, e.what());
  }
}

void BusListener::OnStatus(std::span<const uint8_t> bytes, StageMonitor::Clock::time_point now) {
  const Result<StageStatus> status = DecodeStatus(bytes);
  if (!status) return monitor_.BadMessage(kStatusChannel, status.error().text);
  history_.Add(*status, NowUtime(), now);
  duplicates_.Heard(*status);
}

void BusListener::OnNewest(StageMonitor::Clock::time_point now) {
  const StoredFramePtr newest = ring_.Newest();
  if (newest_key_ != newest->key) {
    newest_key_ = newest->key;
    gaps_.Add(newest->id);
    monitor_.SetJoinerCounts(/*incomplete=*/0, gaps_.count());
    monitor_.FrameIn(/*skipped=*/false);
    monitor_.FrameOut(newest->id, now, /*degenerate=*/"");
  }
  if (newest->Has(Part::kLeft) && newest->Has(Part::kDisparity)) silence_.HeardFrame();
  changed_();
}

const std::vector<std::string> kStages = {"capture", "refine", "prior", "grow"};

struct Options {
  std::string address = "127.0.0.1";
  int port = 8420;
  std::string log;
  std::optional<int64_t> frame;
  int memory_mb = 1024;
};

void WarnOfStrangers(const std::string& address) {
  if (address.starts_with("127.") || address == "::1") return;
  LogLine(
      LogLevel::kWarning,
      "--address {}: everybody who can reach this address sees the images; there is no password",
      address);
}

// Says where the page is, and serves it until a stop is requested.
void Serve(const ServiceContext& context, const Server& server, const Options& options) {
  const bool any = options.address == "0.0.0.0" || options.address == "::";
  const std::string host = any ? "127.0.0.1" : options.address;
  LogLine(LogLevel::kInfo, "look at http://{}:{}/",
          host.find(':') == std::string::npos ? host : "[" + host + "]", server.port());
  while (SleepFor(std::chrono::hours(1), context.stop)) {
  }
}

// The first message to a page, and that of every second. Board and history are JSON already.
std::string Hello(nlohmann::json facts, const StatusHistory& history) {
  facts["type"] = "hello";
  facts["version"] = Version();
  facts["colors"] = ScaleColors();
  std::string text = JsonText(facts);
  text.pop_back();
  return text + R"(,"history":)" + history.HistoryText() + "}";
}

std::string Status(nlohmann::json facts, const StatusHistory& history,
                   StatusBoard::Clock::time_point now) {
  facts["type"] = "status";
  std::string text = JsonText(facts);
  text.pop_back();
  return text + R"(,"board":)" + history.BoardText(now) + "}";
}

nlohmann::json KeysOf(const FrameSource& source) {
  const KeyRange keys = source.keys();
  return {keys.first, keys.last};
}

int ShowGraph(const ServiceContext& context, const Options& options) {
  StageMonitor monitor(context.stage, Digest(ConfigText(context.config)));
  const size_t max_bytes = static_cast<size_t>(options.memory_mb) << 20;
  FrameRing ring(max_bytes);
  StatusHistory history(kStages, /*keep_all=*/false);
  FrameEncoder encoder(
      [&](Part part, const std::string& why) { monitor.BadMessage(ChannelOf(part), why); });
  const HttpHandler handler(ring, encoder, &ring, nullptr, context.prefix);
  Server server(options.address, static_cast<uint16_t>(options.port),
                {.source = &ring,
                 .encoder = &encoder,
                 .handler = &handler,
                 .hello =
                     [&] {
                       return Hello(
                           {{"mode", "live"}, {"url", context.lcm_url}, {"prefix", context.prefix}},
                           history);
                     },
                 .status =
                     [&] {
                       return Status({{"utime", NowUtime()},
                                      {"keys", KeysOf(ring)},
                                      {"kept_mb", static_cast<double>(ring.bytes()) / (1 << 20)},
                                      {"short", ring.is_short()},
                                      {"complaint", monitor.Snapshot().last_error}},
                                     history, StatusBoard::Clock::now());
                     },
                 .keep_bytes = max_bytes});
  const BusListener listener(context, ring, history, monitor, [&] { server.FrameChanged(); });
  const StatusReporter reporter(context, monitor);
  Serve(context, server, options);
  return 0;
}

// The frames of the log, what is wrong with it, and the key of --frame once that is found.
nlohmann::json StartOf(const LogFile& log, std::optional<int64_t> frame) {
  nlohmann::json facts{{"keys", KeysOf(log)}, {"complaint", log.complaint()}};
  if (!frame) return facts;
  const bool is_read = log.progress() >= 1;  // asked before KeyOf(), or the end could be missed
  if (const std::optional<int64_t> key = log.KeyOf(*frame)) {
    facts["start"] = *key;
  } else if (is_read) {
    facts["complaint"] = fmt::format("the log has no frame {}", *frame);
  }
  return facts;
}

int ShowLog(const ServiceContext& context, const Options& options) {
  StatusHistory history({}, /*keep_all=*/true);
  std::mutex mutex;
  Server* told = nullptr;
  LogFile log(options.log, context.prefix, history, [&] {
    const std::lock_guard lock(mutex);
    if (told != nullptr) told->FrameChanged();
  });
  LimitedWarnings undecodable;
  FrameEncoder encoder([&](Part part, const std::string& why) {
    undecodable.Warn(fmt::format("{}: {}", ChannelOf(part), why));
  });
  const HttpHandler handler(log, encoder, nullptr, &log, context.prefix);
  Server server(
      options.address, static_cast<uint16_t>(options.port),
      {.source = &log,
       .encoder = &encoder,
       .handler = &handler,
       .hello =
           [&] {
             nlohmann::json facts = StartOf(log, options.frame);
             facts.update({{"mode", "log"},
                           {"file", std::filesystem::path(options.log).filename().string()},
                           {"prefix", context.prefix}});
             return Hello(std::move(facts), history);
           },
       .status =
           [&] {
             nlohmann::json facts = StartOf(log, options.frame);
             facts["read"] = log.progress();
             return Status(std::move(facts), history, history.newest());
           },
       .keep_bytes = 0});
  const auto tell = [&](Server* whom) {
    const std::lock_guard lock(mutex);
    told = whom;
  };
  tell(&server);
  const LogQuality quality(log);
  Serve(context, server, options);
  tell(nullptr);
  return 0;
}

int Main(int argc, char** argv) {
  Service service("view",
                  "Shows the running graph or a log in a browser: left image, ToF, disparity or "
                  "depth,\nconfidence, prior, seeds, a point cloud, and the state of every "
                  "process.\nOpen http://127.0.0.1:8420/; '?' lists the keys there.\nSubscribes to "
                  "every channel and needs none: missing ones are not shown.");
  Options options;
  Flag log =
      service.flags().Add("--log FILE", options.log, "Show a log instead of the running graph");
  service.flags()
      .Add("--frame N", options.frame,
           "With --log: open at the first frame with this number (header.seq)")
      .WithinWhole(int64_t{0}, INT64_MAX)
      .Needs(log);
  service.flags()
      .Add("--address", options.address,
           "Address to listen on; with another than the loopback's, other hosts can look, too")
      .ShowDefault();
  service.flags()
      .Add("--port", options.port, "0: any free port")
      .WithinWhole(0, 65535)
      .ShowDefault();
  service.flags()
      .Add("--memory", options.memory_mb,
           "Memory for the last 100 frames, MB; paused pages may take as much again")
      .WithinWhole(16, 1 << 20)
      .ShowDefault();
  return service.Run(argc, argv, [&](const ServiceContext& context) {
    WarnOfStrangers(options.address);
    try {
      return options.log.empty() ? ShowGraph(context, options) : ShowLog(context, options);
    } catch (const LogError& e) {
      throw ConfigError(std::string("--log: ") + e.what());
    }
  });
}

}  // namespace

}  // namespace sprout::view

int main(int argc, char** argv) { return sprout::view::Main(argc, argv); }
