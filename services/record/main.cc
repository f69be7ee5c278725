#include <fmt/core.h>
#include <pthread.h>
#include <sys/time.h>

#include <chrono>
#include <cmath>
#include <csignal>
#include <memory>
#include <set>

#include "common/app/log.h"
#include "common/app/service.h"
#include "common/app/status_reporter.h"
#include "common/app/supervision.h"
#include "common/bus/channels.h"
#include "common/core/digest.h"
#include "services/record/recording.h"

namespace sprout::record {
namespace {

struct Options {
  std::string folder;
  std::vector<std::string> channels;
  double max_mb = 1000;
  double quota_gb = 20;
  bool delete_oldest = false;
  std::optional<double> ring_s;
  double ring_mb = 500;
  double after_s = 10;
  std::optional<std::string> trigger_channel;
  std::optional<double> trigger_confidence;
  std::optional<double> seconds;
  bool compress = false;
  std::optional<int> jpeg_quality;
};

constexpr char kDescription[] =
    "Records the running graph to LCM logs, record_NUMBER_DATE_TIME.lcm in a folder.\n"
    "\n"
    "  sprout-record --dir /data                                    everything, until Ctrl-C\n"
    "  sprout-record --dir /data --compress                         the same in about half the\n"
    "                                                               bytes\n"
    "  sprout-record --dir /data --quota-gb 50 --delete-oldest      the last 50 GB\n"
    "  sprout-record --dir /data --ring 20 --trigger-confidence 0.3 20 s before and 10 s after\n   "
    "                                                            low confidence\n"
    "  kill -USR1 PID                                               keep the last seconds\n"
    "\n"
    "Exit codes: 0; 1 when it had to stop (quota, disk), lost messages or received none; 2 a flag\n"
    "that cannot be used.";

RecordedEvent::Clock::duration Seconds(double seconds) {
  return std::chrono::duration_cast<RecordedEvent::Clock::duration>(
      std::chrono::duration<double>(seconds));
}

void RequireChannel(const std::string& flag, const std::string& channel) {
  constexpr char kAllowed[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_-";
  // A name may still be too long for LCM with the prefix before it. No message comes on that.
  if (!channel.empty() && channel.size() <= 63 &&
      channel.find_first_not_of(kAllowed) == std::string::npos) {
    return;
  }
  throw ConfigError(flag + " '" + channel +
                    "': allowed are 1 to 63 letters, digits, '_' and '-', without prefix");
}

RecordingOptions OptionsOf(const Options& options) {
  RecordingOptions recording;
  // A set, since a channel may be named twice: by a script and by its user.
  const std::set<std::string> names(options.channels.begin(), options.channels.end());
  recording.channels.assign(names.begin(), names.end());
  recording.named = !options.channels.empty();
  if (recording.channels.empty()) {
    for (const std::string_view channel : AllChannels()) recording.channels.emplace_back(channel);
  }
  for (const std::string& channel : recording.channels) RequireChannel("--channels", channel);
  recording.folder = {.folder = options.folder,
                      .max_file_bytes = std::llround(options.max_mb * 1e6),
                      .quota_bytes = std::llround(options.quota_gb * 1e9),
                      .delete_oldest = options.delete_oldest};
  if (options.delete_oldest && options.max_mb > options.quota_gb * 1000 / 2) {
    throw ConfigError(
        fmt::format("--max-mb {}: allowed with --delete-oldest is up to half of --quota-gb, {} MB",
                    options.max_mb, options.quota_gb * 1000 / 2));
  }
  if (options.ring_s) {
    recording.ring = {.length = Seconds(*options.ring_s),
                      .max_bytes = static_cast<size_t>(options.ring_mb * 1e6),
                      .after = Seconds(options.after_s)};
  }
  if (options.trigger_channel) RequireChannel("--trigger-channel", *options.trigger_channel);
  recording.trigger_channel = options.trigger_channel;
  recording.trigger_confidence = options.trigger_confidence;
  recording.compress = options.compress || options.jpeg_quality;
  recording.jpeg_quality = options.jpeg_quality;
  return recording;
}

// Waits up to 0.1 s for SIGUSR1, which is blocked in every thread.
bool WaitForTrigger() {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGUSR1);
  constexpr timespec kPoll{.tv_sec = 0, .tv_nsec = 100'000'000};
  return sigtimedwait(&signals, nullptr, &kPoll) == SIGUSR1;
}

// Stops the timer that ends a process some time after a signal: writing what waits may take longer.
// A second signal still ends the process at once.
void StopKillTimer(const Recording& recording) {
  constexpr itimerval kNever{};
  setitimer(ITIMER_REAL, &kNever, nullptr);
  const double waiting_mb = static_cast<double>(recording.waiting_bytes()) / 1e6;
  if (waiting_mb > 1) LogLine(LogLevel::kInfo, "writing the {:.0f} MB that wait", waiting_mb);
}

// @throws ConfigError, not LogError, for a folder that cannot be written from the start: --dir is
//         wrong then.
std::unique_ptr<Recording> Begin(const ServiceContext& context, const RecordingOptions& options,
                                 StageMonitor& monitor) {
  try {
    return std::make_unique<Recording>(context, options, monitor);
  } catch (const LogError& e) {
    throw ConfigError(std::string("--dir: ") + e.what());
  }
}

// @param length  nothing: until a stop is requested.
int Record(const ServiceContext& context, const RecordingOptions& options,
           const std::optional<double>& length_s) {
  StageMonitor monitor(context.stage, Digest(ConfigText(context.config)));
  const std::unique_ptr<Recording> begun = Begin(context, options, monitor);
  Recording& recording = *begun;
  {
    const StatusReporter reporter(context, monitor);
    NotifyReady();
    const auto begin = RecordedEvent::Clock::now();
    auto next_status = begin;
    while (!context.stop.stop_requested() && !recording.has_failed()) {
      if (length_s && RecordedEvent::Clock::now() >= begin + Seconds(*length_s)) break;
      if (WaitForTrigger()) recording.Trigger("SIGUSR1");
      if (RecordedEvent::Clock::now() < next_status) continue;
      recording.PutStatus();
      next_status += std::chrono::seconds(1);
    }
    // The stop may come before Finish() or during it.
    const std::stop_callback more_time(context.stop, [&] { StopKillTimer(recording); });
    recording.Finish();
  }
  const bool whole = recording.IsWhole();
  LogLine(whole ? LogLevel::kInfo : LogLevel::kWarning, recording.Summary());
  return whole ? 0 : 1;
}

void AddFlags(Flags& flags, Options& options) {
  flags.Add("--dir DIR", options.folder, "Folder to write to; created if missing").Required();
  flags
      .Add("--channels NAME,NAME,...", options.channels,
           "Only these (without prefix); your own are allowed; may be given several times; "
           "default: every channel of the graph")
      .SplitAtCommas()
      .Repeatable();
  flags.Add("--seconds SECONDS", options.seconds, "Stop after this many seconds").Within(0.1, 1e9);
  flags.Add("--compress", options.compress,
            "Images, maps, seeds and points in fewer bytes, without loss: about half. Every "
            "program of Sprout reads the log; for others: sprout-log expand");
  flags
      .Add("--jpeg QUALITY", options.jpeg_quality,
           "The same, with left and right images as JPEG of this quality: a tenth of their bytes, "
           "but what is lost does not come back, and replays differ")
      .WithinWhole(1, 100);
  flags.Add("--max-mb", options.max_mb, "Size of a log at which the next one begins, MB")
      .Within(0.1, 1e6)
      .ShowDefault();
  flags.Add("--quota-gb", options.quota_gb, "Largest size of the folder with all its files, GB")
      .Within(0.001, 1e6)
      .ShowDefault();
  flags.Add("--delete-oldest", options.delete_oldest,
            "At the quota delete the oldest log record_*.lcm instead of stopping");
  const Flag ring = flags
                        .Add("--ring SECONDS", options.ring_s,
                             "Keep the last seconds in memory and write nothing until a trigger")
                        .Within(1.0, 3600.0);
  flags.Add("--ring-mb", options.ring_mb, "Memory for --ring, MB")
      .Within(0.1, 1e6)
      .ShowDefault()
      .Needs(ring);
  flags.Add("--after", options.after_s, "How long to record after a trigger, s")
      .Within(0.0, 3600.0)
      .ShowDefault()
      .Needs(ring);
  flags
      .Add("--trigger-channel NAME", options.trigger_channel,
           "Any message on this channel (without prefix) is a trigger")
      .Needs(ring);
  flags
      .Add("--trigger-confidence", options.trigger_confidence,
           "A SPROUT_CONFIDENCE with a mean below this is a trigger; 0 to 1, pixels without "
           "disparity count as 0")
      .Within(0.0, 1.0)
      .Needs(ring);
}

int Main(int argc, char** argv) {
  // The signal is blocked before any thread begins, so that it is blocked in all of them.
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGUSR1);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  Service service("record", kDescription);
  Options options;
  AddFlags(service.flags(), options);
  return service.Run(argc, argv, [&](const ServiceContext& context) {
    return Record(context, OptionsOf(options), options.seconds);
  });
}

}  // namespace
}  // namespace sprout::record

int main(int argc, char** argv) { return sprout::record::Main(argc, argv); }
