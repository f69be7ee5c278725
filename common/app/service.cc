#include "common/app/service.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <map>
#include <opencv2/core/utility.hpp>

#include "common/app/compute.h"
#include "common/app/log.h"
#include "common/app/program.h"
#include "common/app/supervision.h"
#include "common/app/version.h"
#include "common/bus/lcm_url.h"
#include "common/core/digest.h"
#include "common/core/signal_watcher.h"

namespace sprout {
namespace {

// How long a process has to end by itself after SIGINT or SIGTERM. Supervisors kill after some
// seconds; whoever sits in front of it presses Ctrl-C again.
constexpr std::chrono::milliseconds kGracePeriod{1500};

std::string DefaultLcmUrl() {
  const char* from_environment = std::getenv("LCM_DEFAULT_URL");
  return from_environment != nullptr && *from_environment != '\0' ? from_environment
                                                                  : kDefaultLcmUrl;
}

// The values of --log-level.
const std::map<std::string, LogLevel> kLogLevels = {{"debug", LogLevel::kDebug},
                                                    {"info", LogLevel::kInfo},
                                                    {"warning", LogLevel::kWarning},
                                                    {"error", LogLevel::kError}};

// What a configuration is made of. Without any, the parameters have the values of preset default.
std::string ConfigNames(const std::vector<std::string>& files) {
  constexpr size_t kMaxLetters = 100;  // settings may be given as text
  if (files.empty()) return "preset default";
  std::string names = fmt::format("{}", fmt::join(files, ", "));
  std::ranges::replace(names, '\n', ' ');
  return names.size() <= kMaxLetters ? names : names.substr(0, kMaxLetters) + "...";
}

void RequireValidUrl(const std::string& url) {
  if (const auto error = LcmUrlError(url)) throw ConfigError("--lcm-url: " + *error);
}

}  // namespace

Service::Service(std::string stage, const std::string& description, const std::string& program)
    : stage_(std::move(stage)),
      version_(program.empty() ? Version() : program + " on sprout " + Version()),
      lcm_url_(DefaultLcmUrl()),
      flags_(program.empty() ? "sprout-" + stage_ : program, description) {
  flags_
      .Add("--config FILE|PRESET", config_files_,
           "Configuration file in protobuf text format, or the name of a preset; may be "
           "given several times, later files override earlier ones")
      .Repeatable();
  flags_.Add("--lcm-url URL", lcm_url_, "The bus: udpm://GROUP:PORT?ttl=0 or tcpq://HOST:PORT")
      .ShowDefault();
  flags_.Add("--channel-prefix TEXT", prefix_,
             "Prefix of every channel, to run two graphs side by side");
  flags_.Add("--log-level", log_level_, "What to log to stderr")
      .OneOf({"debug", "info", "warning", "error"})
      .ShowDefault();
  flags_
      .Add("--threads", threads_,
           "Threads to compute with, 0 = one a core; results do not depend on it")
      .WithinWhole(0, kMaxThreads)
      .ShowDefault();
  flags_
      .Add("--simd best|" + fmt::format("{}", fmt::join(SimdLevels(), "|")), simd_,
           "Best instruction set that growth and gap filling may use; results do not depend on it")
      .ShowDefault();
  flags_.AddVersion(program.empty() ? Version() : "on sprout " + Version());
}

void Service::OfferReplay() {
  Flag replay = flags_
                    .Add("--replay LOG", replay_,
                         "Process all frames of this log instead of live ones, as fast as "
                         "possible; may be given several times: events are merged by time, and a "
                         "channel is taken from the last log that has it")
                    .Repeatable();
  Flag record = flags_.Add("--record LOG", record_, "Log for the answers of --replay");
  Flag frames =
      flags_.Add("--frames A:B", frames_,
                 "Process only frames A to B of --replay, both included; A:, :B and A work, too");
  replay.Needs(record).Excludes(flags_.Get("--lcm-url"));
  record.Needs(replay);
  frames.Needs(replay);
}

std::optional<ReplayOptions> Service::Replay() const {
  if (replay_.empty()) return std::nullopt;
  ReplayOptions options{.logs = replay_, .record = record_, .frames = {}};
  if (!frames_.empty()) options.frames = ParseFrameRange("--frames", frames_);
  return options;
}

int Service::Run(int argc, char** argv, const Body& body, const ApplyFlags& apply_flags) {
  return RunProgram(flags_, argc, argv, [&] {
    SetUpLog(stage_, kLogLevels.at(log_level_), LogsToJournal());
    return RunChecked(body, apply_flags);
  });
}

int Service::RunChecked(const Body& body, const ApplyFlags& apply_flags) {
  ServiceContext context{.stage = stage_,
                         .version = version_,
                         .config = LoadConfig(config_files_),
                         .lcm_url = lcm_url_,
                         .prefix = prefix_,
                         .replay = Replay(),
                         .stop = {}};
  if (apply_flags) apply_flags(context.config);
  RequireInRange(context.config, "");
  RequireChannelPrefix(prefix_);
  const bool is_live = !context.replay && !flags_.HasCommand();
  if (is_live) RequireValidUrl(lcm_url_);
  KeepMemory();
  SetThreads(threads_);
  LimitSimd(simd_);

  const std::string text = ConfigText(context.config);
  // A foreign program's version begins with its name.
  LogLine(LogLevel::kInfo, "{}, configuration {} of {} (--log-level debug prints it)",
          version_ == Version() ? flags_.program() + " " + version_ : version_, Digest(text),
          ConfigNames(config_files_));
  LogLine(LogLevel::kDebug, "effective configuration:\n{}", text);
  if (is_live) {
    if (const auto warning = ReceiveBufferWarning(lcm_url_)) LogLine(LogLevel::kWarning, *warning);
  }
  const SignalWatcher signals(kGracePeriod, [](int signal) {
    const std::string_view name =
        signal == SIGHUP ? "SIGHUP" : (signal == SIGINT ? "SIGINT" : "SIGTERM");
    LogLine(LogLevel::kInfo, "{}: stopping", name);
  });
  // A tcpq server that hangs up shows as a failed publish, not as the end of the process.
  std::signal(SIGPIPE, SIG_IGN);
  context.stop = signals.token();
  return body(context);
}

}  // namespace sprout
