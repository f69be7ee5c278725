#include "common/app/stage_monitor.h"

#include <gmock/gmock.h>
#include <unistd.h>

#include <algorithm>
#include <thread>

#include "common/app/version.h"
#include "tests/common/app/captured_log.h"

namespace sprout {
namespace {

using std::chrono::milliseconds;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

FrameId IdOf(int64_t seq) { return {.utime = NowUtime() - 5000, .seq = seq, .rig_id = "rig"}; }

class StageMonitorTest : public ::testing::Test {
 protected:
  StageMonitor::Clock::time_point Ago(milliseconds time) const { return now_ - time; }

  CapturedLog log_;
  StageMonitor::Clock::time_point now_ = StageMonitor::Clock::now();  // moves when a test says so
  StageMonitor monitor_{"refine", "0123456789abcdef", [this] { return now_; }};
};

TEST_F(StageMonitorTest, StartsReadyWithItsIdentityAndNothingElse) {
  const StageStatus status = monitor_.Snapshot();
  EXPECT_EQ(status.stage, "refine");
  EXPECT_EQ(status.config_digest, "0123456789abcdef");
  EXPECT_EQ(status.version, Version());
  EXPECT_EQ(status.pid, getpid());
  EXPECT_FALSE(status.host.empty());
  EXPECT_EQ(status.state, StageStatus::State::kReady);
  EXPECT_EQ(status.newest_frame, FrameId{});
  EXPECT_EQ(status.frames_in, 0);
  EXPECT_EQ(status.frames_out, 0);
  EXPECT_EQ(status.rate_hz, 0);
  EXPECT_EQ(status.latency.max_ms, 0);
  EXPECT_EQ(status.last_error, "");
  EXPECT_EQ(status.tof_coverage, kUnknownCoverage);
  EXPECT_GT(status.rss_bytes, 1 << 20);
}

TEST_F(StageMonitorTest, KeepsTheCoverageOfTheNewestFrame) {
  monitor_.FrameOut(IdOf(1), Ago(milliseconds(1)), "", 0.75F);
  EXPECT_EQ(monitor_.Snapshot().tof_coverage, 0.75F);
  monitor_.FrameOut(IdOf(2), Ago(milliseconds(1)), "no seeds", 0);
  EXPECT_EQ(monitor_.Snapshot().tof_coverage, 0);
  monitor_.FrameFailed(IdOf(3), "broken");
  EXPECT_EQ(monitor_.Snapshot().tof_coverage, 0);
  monitor_.FrameOut(IdOf(4), Ago(milliseconds(1)), "");
  EXPECT_EQ(monitor_.Snapshot().tof_coverage, kUnknownCoverage);
}

TEST_F(StageMonitorTest, SaysOnceThatTheNetworkIsAwayAndOnceThatItIsBack) {
  monitor_.StatusSent();
  for (int second = 0; second < 5; ++second) {
    monitor_.FrameNotSent(IdOf(second), "SPROUT_LEFT: unreachable");
    monitor_.NotSent("SPROUT_STATUS: unreachable");
    now_ += std::chrono::seconds(1);
  }
  EXPECT_EQ(monitor_.Snapshot().frames_failed, 5);
  EXPECT_EQ(monitor_.Snapshot().last_error, "frame 4: failed: SPROUT_LEFT: unreachable");
  for (int second = 0; second < 3; ++second) {
    monitor_.StatusSent();
    now_ += std::chrono::seconds(1);
  }
  EXPECT_THAT(log_.Lines(),
              ElementsAre(HasSubstr("frame 0: failed: SPROUT_LEFT: unreachable; what else is not "
                                    "sent is counted until that is over"),
                          HasSubstr("messages are sent again; 10 could not be")));
}

TEST_F(StageMonitorTest, CountsEachKindOfEventByItself) {
  for (int i = 0; i < 5; ++i) monitor_.FrameIn(i >= 3);
  monitor_.FrameOut(IdOf(1), Ago(milliseconds(1)), "");
  monitor_.FrameOut(IdOf(2), Ago(milliseconds(1)), "no seeds");
  monitor_.FrameFailed(IdOf(3), "broken");
  monitor_.FrameFailed(IdOf(3), "broken");
  monitor_.FrameFailed(IdOf(3), "broken");
  for (int i = 0; i < 4; ++i) monitor_.FrameResent(IdOf(4));
  for (int i = 0; i < 6; ++i) monitor_.BadMessage("SPROUT_TOF", "damaged");
  monitor_.SetJoinerCounts(7, 8);
  const StageStatus status = monitor_.Snapshot();
  EXPECT_EQ(status.frames_in, 5);
  EXPECT_EQ(status.frames_skipped, 2);
  EXPECT_EQ(status.frames_out, 2);
  EXPECT_EQ(status.frames_degenerate, 1);
  EXPECT_EQ(status.frames_failed, 3);
  EXPECT_EQ(status.frames_resent, 4);
  EXPECT_EQ(status.bad_messages, 6);
  EXPECT_EQ(status.frames_incomplete, 7);
  EXPECT_EQ(status.sequence_gaps, 8);
  EXPECT_EQ(status.newest_frame.seq, 2) << "a failed frame was not finished";
}

TEST_F(StageMonitorTest, NamesTheNewestThingThatWentWrong) {
  monitor_.FrameOut(IdOf(1), Ago(milliseconds(1)), "");
  EXPECT_EQ(monitor_.Snapshot().last_error, "");
  monitor_.FrameOut(IdOf(2), Ago(milliseconds(1)), "no seeds");
  EXPECT_EQ(monitor_.Snapshot().last_error, "frame 2: no seeds");
  monitor_.FrameOut(IdOf(3), Ago(milliseconds(1)), "");
  EXPECT_EQ(monitor_.Snapshot().last_error, "frame 2: no seeds") << "good frames do not hide it";
  monitor_.FrameFailed(IdOf(4), "broken");
  EXPECT_EQ(monitor_.Snapshot().last_error, "frame 4: failed: broken");
  monitor_.BadMessage("SPROUT_TOF", "width = 0: allowed is 1 to 16384");
  EXPECT_EQ(monitor_.Snapshot().last_error, "SPROUT_TOF: width = 0: allowed is 1 to 16384");
  monitor_.Failure("cannot publish");
  EXPECT_EQ(monitor_.Snapshot().last_error, "cannot publish");
}

TEST_F(StageMonitorTest, RunsOnceAFrameIsAnsweredAndEndsStopped) {
  monitor_.FrameIn(false);
  monitor_.FrameFailed(IdOf(1), "broken");
  EXPECT_EQ(monitor_.Snapshot().state, StageStatus::State::kReady);
  monitor_.FrameOut(IdOf(2), Ago(milliseconds(1)), "");
  EXPECT_EQ(monitor_.Snapshot().state, StageStatus::State::kRunning);
  monitor_.SetStopped();
  EXPECT_EQ(monitor_.Snapshot().state, StageStatus::State::kStopped);
}

TEST_F(StageMonitorTest, SummarisesLatencyByNearestRank) {
  // 1, 2, ... 100 seconds ago, in disorder: the k-th percentile is the k-th value.
  for (int i = 1; i <= 100; ++i) {
    monitor_.FrameOut(IdOf(i), Ago(milliseconds(1000 * (1 + (i * 37) % 100))), "");
  }
  const TimeSummary latency = monitor_.Snapshot().latency;
  EXPECT_EQ(latency.p50_ms, 50'000);
  EXPECT_EQ(latency.p95_ms, 95'000);
  EXPECT_EQ(latency.p99_ms, 99'000);
  EXPECT_EQ(latency.max_ms, 100'000);
}

TEST_F(StageMonitorTest, TakesTheNextHigherRankWhenThereIsNone) {
  for (int i = 1; i <= 10; ++i) monitor_.FrameOut(IdOf(i), Ago(milliseconds(1000 * i)), "");
  const TimeSummary latency = monitor_.Snapshot().latency;
  EXPECT_EQ(latency.p50_ms, 5'000);
  EXPECT_EQ(latency.p95_ms, 10'000) << "rank 9.5";
  EXPECT_EQ(latency.p99_ms, 10'000);
}

TEST_F(StageMonitorTest, ForgetsAllButTheNewest1024Times) {
  monitor_.FrameOut(IdOf(0), Ago(milliseconds(1'000'000)), "");
  for (int i = 1; i <= 1023; ++i) monitor_.FrameOut(IdOf(i), Ago(milliseconds(1)), "");
  EXPECT_GE(monitor_.Snapshot().latency.max_ms, 1'000'000);
  monitor_.FrameOut(IdOf(1024), Ago(milliseconds(1)), "");
  EXPECT_LT(monitor_.Snapshot().latency.max_ms, 100'000);
  EXPECT_EQ(monitor_.Snapshot().frames_out, 1025);
}

TEST_F(StageMonitorTest, MeasuresTheRateOfTheLastTenSeconds) {
  monitor_.FrameOut(IdOf(0), Ago(milliseconds(1)), "");
  now_ += std::chrono::seconds(30);
  for (int i = 1; i <= 6; ++i) {
    now_ += milliseconds(20);
    monitor_.FrameOut(IdOf(i), Ago(milliseconds(1)), "");
  }
  EXPECT_DOUBLE_EQ(monitor_.Snapshot().rate_hz, 50);
  now_ += std::chrono::seconds(11);
  EXPECT_EQ(monitor_.Snapshot().rate_hz, 0);
}

TEST_F(StageMonitorTest, LogsBadMessagesAtMostOnceASecondAndSaysHowManyItKeptSilent) {
  for (int i = 0; i < 1000; ++i) monitor_.BadMessage("SPROUT_TOF", "damaged");
  now_ += milliseconds(999);
  monitor_.BadMessage("SPROUT_TOF", "damaged");
  EXPECT_EQ(monitor_.Snapshot().bad_messages, 1001);
  EXPECT_THAT(log_.Lines(), testing::ElementsAre("warning: SPROUT_TOF: message dropped: damaged"));

  now_ += milliseconds(1);
  monitor_.BadMessage("SPROUT_LEFT", "cut short");
  EXPECT_THAT(log_.Lines().back(), HasSubstr("SPROUT_LEFT: message dropped: cut short (1000 more"));
}

TEST_F(StageMonitorTest, LogsFramesWithoutAResultAtMostOnceASecond) {
  for (int seq = 0; seq < 50; ++seq) {
    monitor_.FrameOut(IdOf(seq), Ago(milliseconds(1)), "no seeds");
    monitor_.FrameFailed(IdOf(seq), "out of memory");
  }
  EXPECT_EQ(monitor_.Snapshot().frames_degenerate, 50);
  EXPECT_EQ(monitor_.Snapshot().frames_failed, 50);
  EXPECT_THAT(log_.Lines(), testing::ElementsAre("warning: frame 0: no seeds",
                                                 "error: frame 0: failed: out of memory"));
}

TEST_F(StageMonitorTest, TakesBracesInAReasonAsTheyAre) {
  monitor_.BadMessage("SPROUT_TOF", "{} {0} {x:");
  monitor_.Failure("{} {0} {x:");
  monitor_.FrameFailed(IdOf(1), "{}");
  ASSERT_THAT(log_.Lines(), ::testing::SizeIs(3));
  EXPECT_THAT(log_.Lines()[0], HasSubstr("{} {0} {x:"));
  EXPECT_EQ(log_.Lines()[1], "error: {} {0} {x:");
  EXPECT_EQ(log_.Lines()[2], "error: frame 1: failed: {}");
}

TEST_F(StageMonitorTest, CountsFromSeveralThreads) {
  {
    std::vector<std::jthread> threads;
    for (int thread = 0; thread < 4; ++thread) {
      threads.emplace_back([this] {
        for (int i = 0; i < 500; ++i) {
          monitor_.FrameIn(false);
          monitor_.FrameOut(IdOf(i), Ago(milliseconds(1)), "");
          monitor_.BadMessage("SPROUT_TOF", "damaged");
          if (i % 50 == 0) monitor_.Snapshot();
        }
      });
    }
  }
  const StageStatus status = monitor_.Snapshot();
  EXPECT_EQ(status.frames_in, 2000);
  EXPECT_EQ(status.frames_out, 2000);
  EXPECT_EQ(status.bad_messages, 2000);
}

TEST_F(StageMonitorTest, WarnsOnceAMinuteOfAToFCameraThatIsOff) {
  monitor_.SetTofOffset({});
  EXPECT_EQ(monitor_.Snapshot().tof_offset.sigma_px, -1);
  monitor_.SetTofOffset({.u_px = 1, .v_px = 0, .sigma_px = 0.5F, .is_off = false});
  EXPECT_EQ(monitor_.Snapshot().last_error, "");
  const TofOffsetStatus off{.u_px = 2.5F, .v_px = -1, .sigma_px = 0.25F, .is_off = true};
  for (int i = 0; i < 3; ++i) monitor_.SetTofOffset(off);
  EXPECT_THAT(monitor_.Snapshot().last_error, testing::HasSubstr("off by (-2.5, 1.0) px"));
  monitor_.SetTofOffset({});
  EXPECT_EQ(monitor_.Snapshot().tof_offset.u_px, 2.5F) << "the newest that is known";
  EXPECT_THAT(monitor_.Snapshot().last_error, testing::HasSubstr("off by (-2.5, 1.0) px"));
  monitor_.SetTofOffset({.u_px = 0.1F, .v_px = 0, .sigma_px = 0.25F, .is_off = false});
  EXPECT_EQ(monitor_.Snapshot().last_error, "") << "it was mended";
  monitor_.SetTofOffset(off);
  EXPECT_THAT(monitor_.Snapshot().last_error, testing::HasSubstr("off by (-2.5, 1.0) px"))
      << "and is off again, which the log need not say within a minute";
}

TEST_F(StageMonitorTest, TellsTheNewestRangeErrorUntilItIsOver) {
  const auto error = [&] { return monitor_.Snapshot().last_error; };
  monitor_.SetFinding("");
  monitor_.SetFinding("off by +10 mm");
  EXPECT_EQ(error(), "off by +10 mm");
  monitor_.SetFinding(std::nullopt);
  EXPECT_EQ(error(), "off by +10 mm") << "not known in this frame";
  monitor_.SetFinding("off by +11 mm");
  EXPECT_EQ(error(), "off by +11 mm");
  monitor_.Failure("the bus is gone");
  monitor_.SetFinding("off by +12 mm");
  EXPECT_EQ(error(), "the bus is gone");
  now_ += std::chrono::minutes(1);
  monitor_.SetFinding("off by +13 mm");
  EXPECT_EQ(error(), "off by +13 mm");
  monitor_.SetFinding("");
  EXPECT_EQ(error(), "") << "it was mended";
  const std::vector<std::string> lines = log_.Lines();
  const auto is_warning = [](const std::string& line) {
    return line.find("off by") != std::string::npos && line.find("over:") == std::string::npos;
  };
  EXPECT_EQ(std::ranges::count_if(lines, is_warning), 2) << "once a minute";
}

TEST_F(StageMonitorTest, TakesBackWhatIsOverUnlessSomethingElseCame) {
  monitor_.Warn("no whole frame");
  monitor_.Resolve("no whole frame");
  EXPECT_EQ(monitor_.Snapshot().last_error, "");
  monitor_.Warn("no whole frame");
  monitor_.Failure("the bus is gone");
  monitor_.Resolve("no whole frame");
  EXPECT_EQ(monitor_.Snapshot().last_error, "the bus is gone");
}

TEST_F(StageMonitorTest, SaysNoMoreOftenThatSomethingIsOverThanThatItBegan) {
  const TofOffsetStatus off{.u_px = 2.5F, .v_px = -1, .sigma_px = 0.25F, .is_off = true};
  const TofOffsetStatus small{.u_px = 0.1F, .v_px = 0, .sigma_px = 0.25F, .is_off = false};
  for (int64_t seq = 0; seq < 100; seq += 2) {  // frames that differ, within a second
    monitor_.SetTofOffset(off);
    monitor_.SetTofOffset(small);
    monitor_.SetFinding("off by +10 mm");
    monitor_.SetFinding("");
    monitor_.FrameOut({.utime = NowUtime() + 60'000'000, .seq = seq, .rig_id = ""}, now_, "");
    monitor_.FrameOut({.utime = NowUtime(), .seq = seq + 1, .rig_id = ""}, now_, "");
    monitor_.HoldWarning("no whole frame");
    monitor_.Resolve("no whole frame");
  }
  EXPECT_EQ(monitor_.Snapshot().last_error, "");
  const auto count = [&](const char* text) {
    return std::ranges::count_if(log_.Lines(), [&](const std::string& line) {
      return line.find("over:") != std::string::npos && line.find(text) != std::string::npos;
    });
  };
  EXPECT_EQ(count("calibrate again"), 1);
  EXPECT_EQ(count("off by +10 mm"), 1);
  EXPECT_EQ(count("in the future"), 1);
  EXPECT_EQ(count("no whole frame"), 1);
  now_ += std::chrono::seconds(1);
  monitor_.HoldWarning("no whole frame");
  monitor_.Resolve("no whole frame");
  EXPECT_EQ(count("no whole frame (49 more since the last such line)"), 1);
}

TEST_F(StageMonitorTest, HasNoRateOfFramesOfOneMoment) {
  for (int64_t seq = 0; seq < 3; ++seq) {
    monitor_.FrameOut(IdOf(seq), now_, "");
    EXPECT_EQ(monitor_.Snapshot().rate_hz, 0);
  }
}

TEST_F(StageMonitorTest, HasTheRateOfFramesThatAreFartherApartThanItsWindow) {
  for (int64_t seq = 0; seq < 3; ++seq) {
    monitor_.FrameOut(IdOf(seq), now_, "");
    now_ += std::chrono::seconds(20);
  }
  EXPECT_DOUBLE_EQ(monitor_.Snapshot().rate_hz, 0.05);
  now_ += std::chrono::seconds(21);
  EXPECT_EQ(monitor_.Snapshot().rate_hz, 0) << "the next one is long due";
}

TEST_F(StageMonitorTest, ForgetsWhatWasFoundOfTheRangeSensorOfAnotherCalibration) {
  monitor_.SetRig("with ToF");
  monitor_.SetTofOffset({.u_px = 2.5F, .v_px = -1, .sigma_px = 0.25F, .is_off = true});
  monitor_.SetFinding("off by +10 mm");
  monitor_.SetRig("with ToF");
  EXPECT_EQ(monitor_.Snapshot().tof_offset.u_px, 2.5F);
  EXPECT_EQ(monitor_.Snapshot().last_error, "off by +10 mm");
  monitor_.SetRig("without");
  EXPECT_EQ(monitor_.Snapshot().tof_offset.sigma_px, -1);
  EXPECT_EQ(monitor_.Snapshot().last_error, "");
}

TEST_F(StageMonitorTest, TellsAnErrorOfOneFrameUntilAMinuteWasAnsweredWithoutALoss) {
  const auto error_after = [&](std::chrono::seconds time, bool answered) {
    now_ += time;
    if (answered) monitor_.FrameOut({.utime = NowUtime(), .seq = 9, .rig_id = ""}, now_, "");
    return monitor_.Snapshot().last_error;
  };
  using std::chrono::seconds;
  monitor_.FrameFailed({.utime = 1, .seq = 3, .rig_id = ""}, "bad luck");
  EXPECT_EQ(error_after(seconds(59), true), "frame 3: failed: bad luck");
  EXPECT_EQ(error_after(seconds(600), false), "frame 3: failed: bad luck") << "no answer";
  monitor_.FrameIn(/*skipped=*/true);
  EXPECT_EQ(error_after(seconds(59), true), "frame 3: failed: bad luck") << "a loss";
  monitor_.SetJoinerCounts(1, 0);
  EXPECT_EQ(error_after(seconds(59), true), "frame 3: failed: bad luck") << "a loss";
  EXPECT_EQ(error_after(seconds(1), true), "");
}

TEST_F(StageMonitorTest, TellsAWarningAsLongAsItIsTrue) {
  const auto error_after_an_hour = [&] {
    now_ += std::chrono::hours(1);
    monitor_.FrameOut({.utime = NowUtime(), .seq = 9, .rig_id = ""}, now_, "");
    return monitor_.Snapshot().last_error;
  };
  monitor_.HoldWarning("small receive buffer");
  monitor_.HoldWarning("another sprout-grow");
  EXPECT_EQ(error_after_an_hour(), "another sprout-grow");
  monitor_.FrameFailed({.utime = 1, .seq = 3, .rig_id = ""}, "bad luck");
  EXPECT_EQ(monitor_.Snapshot().last_error, "frame 3: failed: bad luck");
  EXPECT_EQ(error_after_an_hour(), "another sprout-grow");
  monitor_.Resolve("another sprout-grow");
  EXPECT_EQ(error_after_an_hour(), "small receive buffer");
  monitor_.Resolve("small receive buffer");
  EXPECT_EQ(error_after_an_hour(), "");
}

TEST_F(StageMonitorTest, ForgetsTheAgesOfARecordingWhenCamerasFollow) {
  const auto answer = [&](int64_t seq, int64_t age_us) {
    monitor_.FrameOut({.utime = NowUtime() - age_us, .seq = seq, .rig_id = ""}, now_, "");
  };
  for (int64_t seq = 0; seq < 5; ++seq) answer(seq, 328'000'000);
  EXPECT_GT(monitor_.Snapshot().age.p99_ms, 300'000);
  for (int64_t seq = 5; seq < 8; ++seq) answer(seq, 50'000);
  EXPECT_LT(monitor_.Snapshot().age.max_ms, 1000);
  EXPECT_GE(monitor_.Snapshot().age.p50_ms, 50);
}

}  // namespace
}  // namespace sprout
