#include "common/app/service.h"

#include <gmock/gmock.h>

#include <chrono>
#include <csignal>
#include <sstream>
#include <thread>

#include "common/app/version.h"
#include "common/bus/channels.h"
#include "common/bus/lcm_url.h"
#include "common/core/sleep.h"
#include "tests/common/app/run_main.h"

namespace sprout {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using ::testing::StartsWith;

struct Ended {
  int exit_code;
  bool body_ran;
  std::string out;
  std::vector<std::string> err;  ///< lines
};

std::vector<std::string> Lines(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

// Runs a service in this process, with what main() would hand to it.
Ended RunWith(std::vector<std::string> flags, const Service::Body& body = {},
              const Service::ApplyFlags& apply_flags = {}, bool can_replay = false) {
  flags.insert(flags.begin(), "sprout-probe");
  std::vector<char*> argv;
  for (std::string& flag : flags) argv.push_back(flag.data());
  argv.push_back(nullptr);
  bool body_ran = false;
  const MainOutcome outcome = Captured([&] {
    Service service("probe", "Probes the main that all services share.");
    if (can_replay) service.OfferReplay();
    return service.Run(
        static_cast<int>(flags.size()), argv.data(),
        [&](const ServiceContext& context) {
          body_ran = true;
          return body ? body(context) : 0;
        },
        apply_flags);
  });
  return {outcome.exit_code, body_ran, outcome.out, Lines(outcome.err)};
}

TEST(Service, SaysAtTheStartOfWhichConfigurationItIs) {
  const Ended plain = RunWith({});
  ASSERT_FALSE(plain.err.empty());
  EXPECT_THAT(plain.err[0], HasSubstr("sprout-probe " + Version() + ", configuration "));
  EXPECT_THAT(plain.err[0], HasSubstr(" of preset default (--log-level"));
  const Ended other = RunWith({"--config", "fast", "--config", "grow {\n sub_pixel: true }"});
  EXPECT_THAT(other.err[0], HasSubstr(" of fast, grow {  sub_pixel: true } (--log-level"));
}

TEST(Service, HasTheNameOfAForeignProgram) {
  char name[] = "/home/me/mean_prior.py";
  char* argv[] = {name, nullptr};
  std::string version;
  ::testing::internal::CaptureStderr();
  Service("probe", "Probes.", "mean_prior.py").Run(1, argv, [&](const ServiceContext& context) {
    version = context.version;
    EXPECT_EQ(context.stage, "probe");
    return 0;
  });
  EXPECT_THAT(::testing::internal::GetCapturedStderr(),
              HasSubstr("mean_prior.py on sprout " + Version() + ", configuration "));
  EXPECT_EQ(version, "mean_prior.py on sprout " + Version());
}

TEST(Service, RefusesFlagsThatCannotBeUsedInOneLineThatNamesThem) {
  const struct {
    std::vector<std::string> flags;
    const char* named;
  } table[] = {
      {{"--no-such-flag"}, "--no-such-flag"},
      {{"stray"}, "stray"},
      {{"stray", "--two", "--three"}, "stray"},
      {{"--config"}, "--config"},
      {{"--config", "no_such_preset"}, "no_such_preset"},
      {{"--config", "/"}, "/"},
      {{"--channel-prefix", "two words"}, "two words"},
      {{"--channel-prefix", "A.*"}, "A.*"},
      {{"--channel-prefix", std::string(kMaxChannelPrefix + 1, 'x')}, "--channel-prefix"},
      {{"--lcm-url", "memq://"}, "--lcm-url: LCM URL memq://: no such kind"},
      {{"--lcm-url", "udpm://239.255.76.67:7667?ttl=999"}, "ttl=999"},
      {{"--log-level", "loud"}, "loud"},
      {{"--threads", "-1"}, "--threads"},
      {{"--simd", "mmx"}, "best"},
  };
  for (const auto& [flags, named] : table) {
    const Ended ended = RunWith(flags);
    EXPECT_EQ(ended.exit_code, 2) << named;
    EXPECT_FALSE(ended.body_ran) << named;
    ASSERT_THAT(ended.err, SizeIs(1)) << named;
    EXPECT_THAT(ended.err[0], ::testing::AllOf(StartsWith("sprout-probe: "), HasSubstr(named)));
    EXPECT_EQ(ended.out, "");
  }
}

TEST(Service, ShowsHelpAndVersion) {
  const Ended help = RunWith({"--help"});
  EXPECT_EQ(help.exit_code, 0);
  EXPECT_FALSE(help.body_ran);
  EXPECT_THAT(help.err, IsEmpty());
  for (const char* flag : {"Probes the main", "--config", "--lcm-url", "--channel-prefix",
                           "--log-level", "--threads", "--simd", "--version", "--help"}) {
    EXPECT_THAT(help.out, HasSubstr(flag));
  }
  const Ended version = RunWith({"--version"});
  EXPECT_EQ(version.exit_code, 0);
  EXPECT_FALSE(version.body_ran);
  EXPECT_EQ(version.out, "sprout-probe " + Version() + "\n");
  EXPECT_THAT(version.err, IsEmpty());
}

TEST(Service, HandsTheFlagsToItsBodyAndReturnsWhatThatReturns) {
  const Ended ended = RunWith({"--lcm-url", "udpm://239.255.76.67:7668", "--channel-prefix", "A_",
                               "--config", "paper", "--config", "default"},
                              [](const ServiceContext& context) {
                                EXPECT_EQ(context.stage, "probe");
                                EXPECT_EQ(context.lcm_url, "udpm://239.255.76.67:7668");
                                EXPECT_EQ(context.prefix, "A_");
                                EXPECT_EQ(context.config.grow().fill(), GrowConfig::PRIOR);
                                EXPECT_EQ(context.config.capture().tof_grid_px(), 10);
                                EXPECT_FALSE(context.stop.stop_requested());
                                return 7;
                              });
  EXPECT_EQ(ended.exit_code, 7);
  EXPECT_TRUE(ended.body_ran);
}

TEST(Service, AcceptsTheLongestPrefix) {
  EXPECT_EQ(RunWith({"--channel-prefix", std::string(kMaxChannelPrefix, 'x')}).exit_code, 0);
}

TEST(Service, PrintsTheEffectiveConfigurationWhenAsked) {
  const Ended ended = RunWith({"--config", "paper", "--log-level", "debug"});
  EXPECT_EQ(ended.exit_code, 0);
  std::string err;
  for (const std::string& line : ended.err) err += line + "\n";
  EXPECT_THAT(err, HasSubstr("sigma_p_px: 17.4"));
  EXPECT_THAT(err, HasSubstr("view_margin: 1.15")) << "defaults too";
  EXPECT_THAT(err, HasSubstr(Version()));
}

TEST(Service, IsSilentBelowItsLogLevel) {
  EXPECT_THAT(RunWith({"--log-level", "error"}).err, IsEmpty());
}

TEST(Service, ChecksTheConfigurationAfterItsOwnFlags) {
  const auto rate = [](double hz) {
    return [hz](SproutConfig& config) { config.mutable_capture()->set_rate_hz(hz); };
  };
  const Ended bad = RunWith({}, {}, rate(-1));
  EXPECT_EQ(bad.exit_code, 2);
  EXPECT_FALSE(bad.body_ran);
  ASSERT_THAT(bad.err, SizeIs(1));
  EXPECT_THAT(bad.err[0], HasSubstr("capture.rate_hz = -1: out of range; allowed: 0 to 1000"));
  const auto expect_rate = [](const ServiceContext& context) {
    EXPECT_EQ(context.config.capture().rate_hz(), 3);
    return 0;
  };
  EXPECT_EQ(RunWith({}, expect_rate, rate(3)).exit_code, 0);
}

TEST(Service, TurnsErrorsOfItsBodyIntoOneLineAndAnExitCode) {
  const auto body_that_throws = [](auto error) {
    return [error](const ServiceContext&) -> int { throw error; };
  };
  const std::vector<std::string> quiet = {"--log-level", "error"};
  const Ended bus = RunWith(quiet, body_that_throws(BusError("no route")));
  EXPECT_EQ(bus.exit_code, 1);
  EXPECT_THAT(bus.err, ::testing::ElementsAre("sprout-probe: no route"));
  const Ended config = RunWith(quiet, body_that_throws(ConfigError("bad key")));
  EXPECT_EQ(config.exit_code, 2);
  EXPECT_THAT(config.err, ::testing::ElementsAre("sprout-probe: bad key"));
  const Ended other = RunWith(quiet, body_that_throws(std::runtime_error("disk full")));
  EXPECT_EQ(other.exit_code, 1);
  EXPECT_THAT(other.err, ::testing::ElementsAre("sprout-probe: disk full"));
}

// As RunWith(), for a service that can be replayed.
Ended ReplayWith(const std::vector<std::string>& flags, const Service::Body& body) {
  return RunWith(flags, body, {}, /*can_replay=*/true);
}

TEST(Service, HandsTheReplayToItsBody) {
  const Ended replayed =
      ReplayWith({"--replay", "a", "--replay", "b", "--record", "c", "--frames", "2:4"},
                 [](const ServiceContext& context) {
                   EXPECT_TRUE(context.replay);
                   EXPECT_THAT(context.replay->logs, ::testing::ElementsAre("a", "b"));
                   EXPECT_EQ(context.replay->record, "c");
                   EXPECT_EQ(context.replay->frames, (FrameRange{.first = 2, .last = 4}));
                   return 0;
                 });
  EXPECT_EQ(replayed.exit_code, 0);
  const Ended live = ReplayWith({}, [](const ServiceContext& context) {
    EXPECT_FALSE(context.replay);
    return 0;
  });
  EXPECT_EQ(live.exit_code, 0);
}

TEST(Service, RefusesReplayFlagsThatDoNotGoTogether) {
  const std::vector<std::vector<std::string>> table = {
      {"--replay", "a"},
      {"--record", "c"},
      {"--frames", "1:2"},
      {"--replay", "a", "--record", "c", "--lcm-url", "udpm://"},
      {"--replay", "a", "--record", "c", "--frames", "2:1"},
      {"--replay", "a", "--record", "c", "--record", "d"},
  };
  for (const std::vector<std::string>& flags : table) {
    const Ended ended = ReplayWith(flags, [](const ServiceContext&) { return 0; });
    EXPECT_EQ(ended.exit_code, 2) << flags.back();
    EXPECT_FALSE(ended.body_ran) << flags.back();
    EXPECT_THAT(ended.err, SizeIs(1)) << flags.back();
  }
}

TEST(Service, StopsItsBodyOnSigtermAndSigint) {
  for (const int signal : {SIGTERM, SIGINT}) {
    const Ended ended = RunWith({}, [&](const ServiceContext& context) {
      kill(getpid(), signal);
      SleepFor(std::chrono::seconds(20), context.stop);
      return context.stop.stop_requested() ? 0 : 9;
    });
    EXPECT_EQ(ended.exit_code, 0);
  }
}

// As if in a read, a send or a computation that does not return.
[[noreturn]] void NeverReturn() {
  while (true) std::this_thread::sleep_for(std::chrono::hours(1));
}

// Without a look at what is printed: GoogleTest looks at that itself.
void RunUnseen(const Service::Body& body) {
  std::string program = "sprout-probe";
  char* argv[] = {program.data(), nullptr};
  Service("probe", "").Run(1, argv, body);
}

TEST(ServiceDeathTest, EndsWithinTwoSecondsOfASignalWhateverItsBodyIsStuckIn) {
  const auto started = std::chrono::steady_clock::now();
  EXPECT_EXIT(RunUnseen([](const ServiceContext&) -> int {
                kill(getpid(), SIGTERM);
                NeverReturn();
              }),
              ::testing::KilledBySignal(SIGALRM), "");
  EXPECT_LT(std::chrono::steady_clock::now() - started, std::chrono::seconds(2));
}

TEST(ServiceDeathTest, EndsAtOnceOnASecondSignal) {
  EXPECT_EXIT(
      RunUnseen([](const ServiceContext& context) -> int {
        kill(getpid(), SIGTERM);
        while (!context.stop.stop_requested()) std::this_thread::yield();
        std::this_thread::sleep_for(std::chrono::milliseconds(200));  // or it is the same one
        kill(getpid(), SIGINT);
        NeverReturn();
      }),
      ::testing::KilledBySignal(SIGINT), "");
}

}  // namespace
}  // namespace sprout
