#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "common/logfile/log_writer.h"
#include "services/batch/frame_rows.h"
#include "services/batch/planning.h"
#include "services/batch/report_charts.h"
#include "services/batch/shard_run.h"
#include "services/batch/tables.h"
#include "services/grow/grow_plug.h"
#include "services/prior/prior_plug.h"
#include "services/refine/refine_plug.h"
#include "tests/common/picture/temporary_directory.h"
#include "tests/services/log/graph_log.h"

namespace sprout {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::SizeIs;

TEST(StageChain, TakesWhatThePlugsJoin) {
  SproutConfig config = LoadConfig({"default"});
  EXPECT_EQ(InputsOf("refine", config), RefinePlug(config.refine()).Inputs());
  for (const auto method : {PriorConfig::DELAUNAY, PriorConfig::EDGES}) {
    for (const bool left_seeds : {false, true}) {
      config.mutable_prior()->set_method(method);
      config.mutable_prior()->set_left_seeds(left_seeds);
      EXPECT_EQ(InputsOf("prior", config), PriorPlug(config.prior()).Inputs());
    }
  }
  for (const auto similarity : {GrowConfig::MNCC, GrowConfig::EPC}) {
    for (const auto fill : {GrowConfig::NONE, GrowConfig::PRIOR}) {
      for (const auto seeds : {GrowConfig::TOF, GrowConfig::HARRIS}) {
        config.mutable_grow()->set_similarity(similarity);
        config.mutable_grow()->set_fill(fill);
        config.mutable_grow()->set_seeds(seeds);
        EXPECT_EQ(InputsOf("grow", config), GrowPlug(config.grow()).Inputs());
      }
    }
  }
}

TEST(StageChain, RefusesGapsAndUnknownStages) {
  EXPECT_THROW(ParseStages("--stages", {"refine", "grow"}), ConfigError);
  EXPECT_THROW(ParseStages("--stages", {"depth"}), ConfigError);
  EXPECT_THAT(ParseStages("--stages", {"prior", "grow"}), SizeIs(2));
}

TEST(LogIndex, IsReadAgainAndMadeAgainWhenTheLogChanged) {
  const LogFolder folder;
  const std::string log = folder.Write("run.lcm", GraphEvents(4));
  const LogIndex made = LogIndex::Ensure(log, folder.File("indexes"));
  EXPECT_EQ(made.path(), log + ".index");
  EXPECT_THAT(made.events(), SizeIs(4 * 6 + 1));
  EXPECT_EQ(made.summary().other_events, 4);  // statuses
  const LogIndex again = LogIndex::Ensure(log, folder.File("indexes"));
  ASSERT_EQ(again.events().size(), made.events().size());
  const IndexedEvent line = ReadIndexLine(made.path(), made.events()[3].line);
  EXPECT_EQ(line.hash, made.events()[3].hash);
  EXPECT_EQ(line.line_end, made.events()[4].line);
  folder.Write("run.lcm", GraphEvents(7));
  EXPECT_GT(LogIndex::Ensure(log, folder.File("indexes")).events().size(), made.events().size());
}

// As a recorder gives them, which never go back in time.
std::vector<Event> InOrder(std::vector<Event> events) {
  std::stable_sort(events.begin(), events.end(),
                   [](const Event& x, const Event& y) { return x.utime < y.utime; });
  return events;
}

PlanOptions RefineOptions(int64_t shard_bytes) {
  return {.inputs = InputsOf(StageNames{"refine", "prior", "grow"}, LoadConfig({"default"})),
          .prefix = "",
          .shard_bytes = shard_bytes};
}

TEST(ShardPlan, CutsAreAboutEvenAndLoseNoFrame) {
  const LogFolder folder;
  const LogIndex index =
      LogIndex::Ensure(folder.Write("run.lcm", InOrder(GraphEvents(40))), folder.File("indexes"));
  const std::vector<Shard> shards = PlanShards(index, RefineOptions(20'000));
  ASSERT_GT(shards.size(), 3U);
  int64_t frames = 0;
  for (const Shard& shard : shards) {
    EXPECT_EQ(shard.first_seq, frames);
    frames += shard.frames;
    EXPECT_EQ(shard.last_seq, frames - 1);
    EXPECT_NEAR(static_cast<double>(shard.bytes), 20'000, 12'000);
    EXPECT_THAT(shard.carried, SizeIs(1));  // the calibration
  }
  EXPECT_EQ(frames, 40);
}

TEST(ShardPlan, ALogWhoseTimeGoesBackIsLeftWhole) {
  const LogFolder folder;
  std::vector<Event> events = InOrder(GraphEvents(40));
  events[100].utime -= 10'000'000;
  const LogIndex index = LogIndex::Ensure(folder.Write("run.lcm", events), folder.File("indexes"));
  EXPECT_TRUE(index.summary().goes_back);
  EXPECT_THAT(PlanShards(index, RefineOptions(20'000)), SizeIs(1));
}

TEST(ShardPlan, AnotherMessageGivesAnotherDigest) {
  const LogFolder folder;
  std::vector<Event> events = GraphEvents(10);
  const auto digest = [&](const char* name) {
    const LogIndex index = LogIndex::Ensure(folder.Write(name, events), folder.File("indexes"));
    return PlanShards(index, RefineOptions(1'000'000)).at(0).input;
  };
  const std::string before = digest("a.lcm");
  EXPECT_EQ(digest("b.lcm"), before);
  EventOf(events, Part::kLeft, 5).data.back() = 77;
  EXPECT_NE(digest("c.lcm"), before);
}

TEST(Tables, AreReadAsTheyWereWritten) {
  const TemporaryDirectory folder;
  const Table table{.columns = {"seq", "x"}, .rows = {{1700000000123456, std::nullopt}, {2, 0.25}}};
  WriteTable(folder / "t.csv", table);
  const Table read = ReadTable(folder / "t.csv");
  EXPECT_EQ(read.columns, table.columns);
  EXPECT_EQ(read.rows, table.rows);
}

TEST(Tables, SayHowFarMapsDiffer) {
  DisparityImage a(cv::Size(10, 1));
  a.counts().setTo(320);
  DisparityImage b(a.counts().clone());
  b.counts()(0, 0) = 320 + 16;                  // half a pixel
  b.counts()(0, 1) = 320 + 96;                  // three
  b.counts()(0, 2) = DisparityImage::kInvalid;  // gone
  const MapChange change = ChangeOf(a, b);
  EXPECT_DOUBLE_EQ(change.changed, 0.3);
  EXPECT_DOUBLE_EQ(change.moved, 0.2);
  EXPECT_DOUBLE_EQ(change.vanished, 0.1);
  EXPECT_DOUBLE_EQ(change.appeared, 0);
  EXPECT_DOUBLE_EQ(change.max_px, 3);
  EXPECT_DOUBLE_EQ(change.mean_px, 3.5 / 9);
}

TEST(Tables, AMissingDisparityIsWrongWhereTheTruthIsKnown) {
  DisparityImage map(cv::Size(4, 1));
  map.counts()(0, 0) = 320;
  map.counts()(0, 1) = 320;
  cv::Mat1f truth = (cv::Mat1f(1, 4) << 10.5, 12, 10, INFINITY);
  EXPECT_DOUBLE_EQ(BadShare(map, truth).value(), 2.0 / 3);
  truth.setTo(NAN);
  EXPECT_EQ(BadShare(map, truth), std::nullopt);
}

TEST(ShardRun, ReadsWhatAReplayReports) {
  const StageRun run = ParseReplayReport(
      "warning\ngrow: 414 events; frames: 45 in, 44 out (2 degenerate), 1 failed, 3 incomplete, 0 "
      "left out; 5 bad messages, 0 damaged bytes; 1.49 s, 30.2 frames/s\n");
  EXPECT_EQ(run.frames_in, 45);
  EXPECT_EQ(run.frames_out, 44);
  EXPECT_EQ(run.degenerate, 2);
  EXPECT_EQ(run.failed, 1);
  EXPECT_EQ(run.bad_messages, 5);
  EXPECT_THROW(ParseReplayReport("no report"), ShardError);
}

TEST(Planning, RefusesWhatIsNotThere) {
  const TemporaryDirectory folder;
  EXPECT_THROW(FindLogs({folder / "none.lcm"}), ConfigError);
  EXPECT_THROW(FindLogs({folder / ""}), ConfigError);  // a folder without logs
  std::ofstream(folder / "a.lcm") << "x";
  EXPECT_THAT(FindLogs({folder / "", folder / "a.lcm"}), SizeIs(1));
}

TEST(ReportCharts, EscapeTextAndLeaveOutWhatIsNotThere) {
  EXPECT_THAT(HistogramSvg("<a&b>", {1, 2}, {}), HasSubstr("&lt;a&amp;b&gt;"));
  EXPECT_EQ(HistogramSvg("x", {NAN}, {}), "");
  EXPECT_THAT(HistogramSvg("x", {1, 2, 2}, {2, 3, 3}), HasSubstr("polyline"));
  EXPECT_THAT(HistogramSvg("x", {1, 1}, {}), Not(HasSubstr("nan")));
}

}  // namespace
}  // namespace sprout
