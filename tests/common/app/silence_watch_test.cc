#include "common/app/silence_watch.h"

#include <gmock/gmock.h>

#include "tests/common/app/captured_log.h"

namespace sprout {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

TEST(SilenceText, NamesWhatIsMissingAndWhatIsHeardInstead) {
  const std::string text = SilenceText({"SPROUT_SEEDS", "SPROUT_RIG"}, {{"SPROUT_RIG", 5}},
                                       {{"SPROUT_LEFT", 10}, {"SPROUT_RIG", 1}});
  EXPECT_THAT(text, AllOf(HasSubstr("nothing heard on SPROUT_SEEDS;"),
                          HasSubstr("heard in a second: SPROUT_LEFT (10), SPROUT_RIG (1)"),
                          ::testing::Not(HasSubstr("prefix"))));
}

TEST(SilenceText, TellsWhatSendsConfidence) {
  const MessageCounts both = {{"SPROUT_LEFT", 5}, {"SPROUT_DISPARITY", 5}};
  EXPECT_THAT(
      SilenceText({"SPROUT_LEFT", "SPROUT_DISPARITY", "SPROUT_CONFIDENCE"}, both, both),
      HasSubstr("nothing heard on SPROUT_CONFIDENCE, which grow sends with grow { publish"));
  EXPECT_THAT(SilenceText({"SPROUT_DISPARITY", "SPROUT_CONFIDENCE"}, {}, {}),
              ::testing::Not(HasSubstr("publish_confidence")));
}

TEST(SilenceText, TellsWhoseMessagesComeInPart) {
  const std::string text = SilenceText({"SPROUT_LEFT", "SPROUT_RIG"}, {}, {{"SPROUT_RIG", 1}},
                                       {{"SPROUT_LEFT", 1}, {"SPROUT_RIG", 1}});
  EXPECT_THAT(text, HasSubstr("; messages of SPROUT_LEFT lack datagrams"));
}

TEST(SilenceText, PointsToChannelsWithAnotherPrefix) {
  EXPECT_THAT(SilenceText({"SPROUT_SEEDS"}, {}, {{"B_SPROUT_SEEDS", 3}, {"B_SPROUT_LEFT", 3}}),
              HasSubstr("with another --channel-prefix: B_SPROUT_SEEDS"));
  EXPECT_THAT(SilenceText({"A_SPROUT_SEEDS"}, {}, {{"SPROUT_SEEDS", 3}}),
              HasSubstr("with another --channel-prefix: SPROUT_SEEDS"));
}

TEST(SilenceText, SaysSoWhenNothingIsHeardOrNothingIsMissing) {
  EXPECT_THAT(SilenceText({"SPROUT_LEFT"}, {}, {}), HasSubstr("nothing else is heard either"));
  EXPECT_THAT(SilenceText({"SPROUT_LEFT"}, {{"SPROUT_LEFT", 2}}, {{"SPROUT_LEFT", 2}}),
              HasSubstr("every channel is heard: have they one utime, seq and rig_id, that of "
                        "capture, and do they come in time?"));
}

TEST(SilenceWatch, WaitsThreeIntervalsOfASlowCamera) {
  using std::chrono::milliseconds;
  const CapturedLog log;
  const ServiceContext context{
      .stage = "grow", .config = {}, .lcm_url = "memq://", .prefix = "", .replay = {}, .stop = {}};
  StageMonitor monitor("grow", "");
  SilenceWatch silence(context, {"SPROUT_LEFT"}, monitor, milliseconds(1000));
  silence.HeardFrame();
  std::this_thread::sleep_for(milliseconds(600));
  silence.HeardFrame();
  std::this_thread::sleep_for(milliseconds(1300));  // of 1800
  EXPECT_THAT(log.Lines(), IsEmpty());
  for (int i = 0; i < 100 && log.Lines().empty(); ++i) {
    std::this_thread::sleep_for(milliseconds(100));
  }
  EXPECT_THAT(log.Lines(), ElementsAre(HasSubstr("what is waited for does not come")));
}

TEST(SilenceWatch, WarnsAgainWhenMoreIsHeard) {
  using std::chrono::milliseconds;
  const CapturedLog log;
  const ServiceContext context{
      .stage = "grow", .config = {}, .lcm_url = "memq://", .prefix = "", .replay = {}, .stop = {}};
  StageMonitor monitor("grow", "");
  SilenceWatch silence(context, {"SPROUT_LEFT", "SPROUT_RIG"}, monitor, milliseconds(1200));
  const auto wait_for = [&](size_t lines) {
    for (int i = 0; i < 100 && log.Lines().size() < lines; ++i) {
      std::this_thread::sleep_for(milliseconds(100));
    }
  };
  wait_for(1);
  silence.Heard("SPROUT_RIG");
  wait_for(2);
  EXPECT_THAT(log.Lines(), ElementsAre(HasSubstr("what is waited for does not come"),
                                       HasSubstr("what is waited for does not come")));
  std::this_thread::sleep_for(milliseconds(1500));  // nothing new
  EXPECT_EQ(log.Lines().size(), 2U);
}

class TwinWatchTest : public ::testing::Test {
 protected:
  StageStatus Other(int32_t pid) const {
    StageStatus status = monitor_.Snapshot();
    status.pid = pid;
    return status;
  }

  CapturedLog log_;
  StageMonitor monitor_{"grow", ""};
  DuplicateWatch duplicates_{monitor_};
};

TEST_F(TwinWatchTest, TellsOfEveryTwinOnce) {
  const int32_t other = monitor_.Snapshot().pid + 1;
  for (int i = 0; i < 3; ++i) duplicates_.Heard(Other(other));
  EXPECT_THAT(log_.Lines(), ElementsAre(AllOf(HasSubstr("another sprout-grow"),
                                              HasSubstr(std::to_string(other)))));
  EXPECT_THAT(monitor_.Snapshot().last_error, HasSubstr("another sprout-grow"));
}

TEST_F(TwinWatchTest, IsOverWhenTheTwinHasEndedOrIsSilent) {
  DuplicateWatch::Clock::time_point now{};
  DuplicateWatch duplicates(monitor_, [&] { return now; });
  const int32_t other = monitor_.Snapshot().pid + 1;
  duplicates.Heard(Other(other));
  StageStatus ended = Other(other);
  ended.state = StageStatus::State::kStopped;
  duplicates.Heard(ended);
  EXPECT_EQ(monitor_.Snapshot().last_error, "");
  duplicates.Heard(Other(other));
  EXPECT_THAT(monitor_.Snapshot().last_error, HasSubstr("another sprout-grow"));
  now += std::chrono::seconds(4);
  duplicates.Heard(monitor_.Snapshot());
  EXPECT_THAT(monitor_.Snapshot().last_error, HasSubstr("another sprout-grow"));
  now += std::chrono::seconds(1);
  duplicates.Heard(monitor_.Snapshot());
  EXPECT_EQ(monitor_.Snapshot().last_error, "");
}

TEST_F(TwinWatchTest, LeavesItselfOtherStagesAndTheOneThatEndedAlone) {
  duplicates_.Heard(monitor_.Snapshot());
  StageStatus prior = Other(1);
  prior.stage = "prior";
  duplicates_.Heard(prior);
  StageStatus ended = Other(2);
  ended.state = StageStatus::State::kStopped;
  duplicates_.Heard(ended);
  EXPECT_THAT(log_.Lines(), IsEmpty());
}

}  // namespace
}  // namespace sprout
