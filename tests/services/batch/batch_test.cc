#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "common/logfile/log_writer.h"
#include "common/messages/codec.h"
#include "common/picture/write_image.h"
#include "services/batch/frame_rows.h"
#include "services/batch/planning.h"
#include "services/batch/report_losses.h"
#include "services/batch/shard_run.h"
#include "services/batch/shard_try.h"
#include "services/batch/stage_run.h"
#include "services/batch/tables.h"
#include "tests/common/picture/temporary_directory.h"
#include "tests/services/log/graph_log.h"

namespace sprout::batch {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::SizeIs;

TEST(StageChain, RefusesGapsAndUnknownStages) {
  EXPECT_THROW(ParseStages("--stages", {"refine", "grow"}), ConfigError);
  EXPECT_THROW(ParseStages("--stages", {"depth"}), ConfigError);
  EXPECT_THAT(ParseStages("--stages", {"prior", "grow"}), SizeIs(2));
}

TEST(LogIndex, IsReadAgainAndMadeAgainWhenTheLogChanged) {
  const log::LogFolder folder;
  const std::string log = folder.Write("run.lcm", log::GraphEvents(4));
  const LogIndex made = LogIndex::Ensure(log, folder.File("indexes"));
  EXPECT_EQ(made.path(), log + ".index");
  EXPECT_THAT(made.events(), SizeIs(4 * 6 + 1));
  EXPECT_EQ(made.summary().other_events, 4);  // statuses
  const LogIndex again = LogIndex::Ensure(log, folder.File("indexes"));
  ASSERT_EQ(again.events().size(), made.events().size());
  const IndexedEvent line = ReadIndexLine(made.path(), made.events()[3].line);
  EXPECT_EQ(line.hash, made.events()[3].hash);
  EXPECT_EQ(line.line_end, made.events()[4].line);
  folder.Write("run.lcm", log::GraphEvents(7));
  EXPECT_GT(LogIndex::Ensure(log, folder.File("indexes")).events().size(), made.events().size());
}

// As a recorder gives them.
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
  const log::LogFolder folder;
  const LogIndex index = LogIndex::Ensure(folder.Write("run.lcm", InOrder(log::GraphEvents(40))),
                                          folder.File("indexes"));
  const std::vector<Shard> shards = PlanShards(index, RefineOptions(20'000)).shards;
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

TEST(ShardPlan, CountsFramesThatAreIncompleteOrLeftOut) {
  const log::LogFolder folder;
  std::vector<Event> events = InOrder(log::GraphEvents(40));
  std::erase_if(events, [](const Event& event) {
    const auto seq = (event.utime - log::LogFrameId(0).utime) / 100'000;
    return (seq == 5 && event.channel == ChannelOf(Part::kTof)) || seq == 11 || seq == 12;
  });
  const LogIndex index = LogIndex::Ensure(folder.Write("run.lcm", events), folder.File("indexes"));
  const LogPlan plan = PlanShards(index, RefineOptions(20'000));
  EXPECT_EQ(plan.incomplete, 1);
  EXPECT_EQ(plan.left_out, 2);
}

TEST(ShardPlan, CutsNowhereBeforeAnEventThatIsOlderThanWhatIsThereAlready) {
  const log::LogFolder folder;
  std::vector<Event> events = InOrder(log::GraphEvents(40));
  const auto shards = [&](const char* name) {
    const LogIndex index = LogIndex::Ensure(folder.Write(name, events), folder.File("indexes"));
    return PlanShards(index, RefineOptions(20'000)).shards;
  };
  const size_t in_order = shards("in_order.lcm").size();
  // Here and there two messages that follow each other have changed places.
  for (size_t i = 7; i < events.size(); i += 7) std::swap(events[i], events[i + 1]);
  EXPECT_EQ(shards("jitter.lcm").size(), in_order);
  // The clock is set back by 1 s in frame 20: the frames whose times come twice stay together.
  for (size_t i = events.size() / 2; i < events.size(); ++i) events[i].utime -= 1'000'000;
  const std::vector<Shard> set_back = shards("set_back.lcm");
  EXPECT_LT(set_back.size(), in_order);
  EXPECT_GT(set_back.size(), 1U);
  EXPECT_THAT(set_back, Contains(testing::Field(&Shard::frames, testing::Gt(18))));
  log::EventOf(events, Part::kLeft, 0).utime += 100'000'000;
  EXPECT_THAT(shards("first_is_ahead.lcm"), SizeIs(1));
}

TEST(ShardPlan, LeavesALogWholeWhereAMessageThatNobodyTakesDisturbsTheOrder) {
  const log::LogFolder folder;
  std::vector<Event> events = InOrder(log::GraphEvents(40));
  Event& bad = log::EventOf(events, Part::kLeft, 14);
  bad.data.resize(4);
  const auto cuttable = [&](const char* name) {
    return LogIndex::Ensure(folder.Write(name, events), folder.File("indexes")).summary().cuttable;
  };
  EXPECT_TRUE(cuttable("damaged.lcm"));
  bad.utime += 1'000'000;
  EXPECT_FALSE(cuttable("ahead.lcm"));
}

TEST(ShardPlan, AnotherMessageGivesAnotherDigest) {
  const log::LogFolder folder;
  std::vector<Event> events = log::GraphEvents(10);
  const auto digest = [&](const char* name) {
    const LogIndex index = LogIndex::Ensure(folder.Write(name, events), folder.File("indexes"));
    return PlanShards(index, RefineOptions(1'000'000)).shards.at(0).input;
  };
  const std::string before = digest("a.lcm");
  EXPECT_EQ(digest("b.lcm"), before);
  log::EventOf(events, Part::kLeft, 5).data.back() = 77;
  EXPECT_NE(digest("c.lcm"), before);
}

TEST(Tables, AreReadAsTheyWereWritten) {
  const TemporaryDirectory folder;
  const Table table{.columns = {"seq", "utime", "x"},
                    .rows = {{1, 1700000000123456, std::nullopt}, {2, 3, 0.25}}};
  WriteTable(folder / "t.csv", table);
  const Table read = ReadTable(folder / "t.csv", {"x"});
  EXPECT_EQ(read.columns, table.columns);
  EXPECT_EQ(read.rows, table.rows);
}

// The answers to one frame.
std::unique_ptr<FrameLookup> Answers(const std::filesystem::path& log, const DisparityImage& map) {
  LogWriter writer(log);
  writer.Write(1, ChannelOf(Part::kDisparity),
               EncodePart(log::LogFrameId(7), Part::kDisparity, map, DisparityEncoding::kRawInt16));
  writer.Close();
  auto lookup = std::make_unique<FrameLookup>("");
  lookup->Add(log);
  return lookup;
}

TEST(Tables, SayHowFarMapsDiffer) {
  const TemporaryDirectory folder;
  DisparityImage a(cv::Size(10, 1));
  a.counts().setTo(320);
  DisparityImage b(a.counts().clone());
  b.counts()(0, 0) = 320 + 16;                  // half a pixel
  b.counts()(0, 1) = 320 + 96;                  // three
  b.counts()(0, 2) = DisparityImage::kInvalid;  // gone
  b.counts()(0, 3) = 320 + 32;                  // one, which is not more than one
  const Table table =
      CompareFrames(*Answers(folder / "a", a), Answers(folder / "b", b).get(), Part::kDisparity,
                    /*truth=*/"");
  ASSERT_THAT(table.rows, SizeIs(1));
  EXPECT_THAT(table.rows[0], ElementsAre(7, log::LogFrameId(7).utime, 0.4, 0.2, 1.5, 3, 0, 0.1,
                                         std::nullopt, std::nullopt));
}

TEST(Tables, AMissingDisparityIsWrongWhereTheTruthIsKnown) {
  const TemporaryDirectory folder;
  DisparityImage map(cv::Size(4, 1));
  map.counts()(0, 0) = 320;
  map.counts()(0, 1) = 320;
  DisparityImage truth(cv::Size(4, 1));
  truth.counts()(0, 0) = 336;  // 10.5 px
  truth.counts()(0, 1) = 384;  // 12
  truth.counts()(0, 2) = 320;  // the map has none; and of the last none is known
  const auto bad_share = [&] {
    EXPECT_TRUE(WritePfm(folder / "000007_disparity.pfm", truth));
    return CompareFrames(*Answers(folder / "a", map), nullptr, Part::kDisparity, folder / "")
        .rows.at(0)
        .at(8);
  };
  EXPECT_NEAR(bad_share().value(), 2.0 / 3, 1e-12);
  truth.counts().setTo(DisparityImage::kInvalid);
  EXPECT_EQ(bad_share(), std::nullopt);
}

TEST(Tables, HaveARowForEachFrameThatIsNotMeasured) {
  const TemporaryDirectory folder;
  const auto lookup = Answers(folder / "a", DisparityImage(cv::Size(4, 1)));
  const Table table = ListFrames(*lookup, Part::kDisparity);
  EXPECT_EQ(table.columns, MeasureFrames(*lookup, Part::kDisparity).columns);
  ASSERT_THAT(table.rows, SizeIs(1));
  std::vector<std::optional<double>> row(table.columns.size());
  row[0] = 7;
  row[1] = static_cast<double>(log::LogFrameId(7).utime);
  EXPECT_EQ(table.rows[0], row);
}

TEST(ShardRun, ReadsWhatAReplayReports) {
  const std::optional<StageRun> run = ParseReplayReport(
      "warning\ngrow: 414 events; frames: 45 in, 44 out (2 degenerate), 1 failed, 3 incomplete, 0 "
      "left out; 5 bad messages, 0 damaged bytes; 1.49 s, 30.2 frames/s\n");
  ASSERT_TRUE(run);
  EXPECT_EQ(run->frames_in, 45);
  EXPECT_EQ(run->frames_out, 44);
  EXPECT_EQ(run->degenerate, 2);
  EXPECT_EQ(run->failed, 1);
  EXPECT_EQ(run->bad_messages, 5);
  EXPECT_EQ(ParseReplayReport("no report"), std::nullopt);
}

TEST(ShardTry, LeavesAFileOfEachTryThatDidNotSucceed) {
  const TemporaryDirectory folder;
  const BatchFolder batch(folder / "");
  { const ShardTry attempt(batch, 7); }
  EXPECT_THAT(FailedTries(batch), IsEmpty());
  {
    ShardTry attempt(batch, 7);
    attempt.Fail("first");
    attempt.Fail("a consequence");
  }
  const ShardTry at_work(batch, 7);
  EXPECT_EQ(FailedTries(batch), (std::map<size_t, int64_t>{{7, 2}}));
  std::string line;
  std::getline(std::ifstream(TryPath(batch, 7, 1)) >> std::ws, line);
  EXPECT_EQ(line, "first");
  ForgetTry(batch, 7);
  EXPECT_EQ(FailedTries(batch), (std::map<size_t, int64_t>{{7, 1}}));
}

// Two logs; the first of two shards, one of which was done at the second try, the second of a shard
// that failed for good.
class LossesOfABatch : public testing::Test {
 protected:
  void SetUp() override {
    manifest_.head.stages = {"prior", "grow"};
    manifest_.head.keep = {"grow"};
    Variant a{.name = "a", .config_digest = "c", .programs = {}};
    for (const std::string& stage : manifest_.head.stages) a.programs[stage] = {"p", "d", "v"};
    manifest_.head.variants = {a};
    BatchLog log{.path = "/x.lcm", .name = "x", .index = "", .summary = {}};
    log.incomplete = 3;
    log.left_out = 4;
    log.summary.undecodable = 5;
    log.summary.damaged_bytes = 600;
    manifest_.logs = {log, {.path = "/y.lcm", .name = "y", .index = "", .summary = {}}};
    for (const int64_t of_log : {0, 0, 1}) {
      Shard shard;
      shard.log = of_log;
      shard.frames = 10;
      shard.input = std::to_string(manifest_.shards.size());
      manifest_.shards.push_back(shard);
    }
    Write(0, {{"prior", {.frames_in = 10, .frames_out = 10, .bad_messages = 2}},
              {"grow", {.frames_in = 10, .frames_out = 8, .degenerate = 1, .bad_messages = 2}}});
    Write(1, {{"prior", {.frames_out = 10}}, {"grow", {.frames_out = 10}}});
    ShardTry(batch_, 1).Fail("out of <luck>");
    for (int i = 0; i < 2; ++i) ShardTry(batch_, 2).Fail("broken");
    state_ = StateOf(batch_, manifest_);
  }

  void Write(size_t shard, const StageRuns& runs) const {
    ResultFolder result(batch_.result(
        ResultKey(manifest_.head, manifest_.head.variants[0], manifest_.shards[shard])));
    WriteStageRuns(result / kRuns, runs);
    result.Commit();
  }

  TemporaryDirectory folder_;
  BatchFolder batch_{folder_ / ""};
  Manifest manifest_;
  BatchState state_;
};

TEST_F(LossesOfABatch, AreCountedPerLog) {
  const std::vector<Losses> logs = LossesOf(batch_, manifest_, state_);
  ASSERT_THAT(logs, SizeIs(2));
  EXPECT_EQ(logs[0].shards, 2);
  EXPECT_EQ(logs[0].retried, 1);
  EXPECT_EQ(logs[0].failed, 0);
  EXPECT_EQ(logs[0].frames, 20);
  EXPECT_EQ(logs[0].variants.at(0).unanswered, 2);
  EXPECT_EQ(logs[0].variants.at(0).empty, 1);
  EXPECT_EQ(logs[0].variants.at(0).refused, 2);
  EXPECT_EQ(logs[1].failed, 1);
  EXPECT_EQ(logs[1].retried, 0);
  EXPECT_TRUE(logs[0].Any() && logs[1].Any());
}

TEST_F(LossesOfABatch, StandInTheReportPerLogAndInAll) {
  const std::string html = LossesHtml(batch_, manifest_, state_);
  EXPECT_THAT(html, HasSubstr("<tr><td>all 2 logs</td><td>3</td><td class=\"bad\">1</td>"
                              "<td class=\"bad\">1</td><td class=\"none\">0</td><td>30</td>"
                              "<td class=\"bad\">2</td><td class=\"bad\">1</td>"
                              "<td class=\"bad\">2</td><td class=\"bad\">3</td>"
                              "<td class=\"bad\">4</td><td class=\"bad\">5</td>"
                              "<td class=\"bad\">600</td></tr>"));
  EXPECT_THAT(
      html, HasSubstr("<tr><td>y</td><td>1</td><td class=\"none\">0</td><td class=\"bad\">1</td>"));
  EXPECT_THAT(html, HasSubstr("missing after 2 failed tries"));
  EXPECT_THAT(html, HasSubstr("failed/1.1.txt\">out of &lt;luck&gt;<"));
}

TEST(Planning, RefusesWhatIsNotThere) {
  const TemporaryDirectory folder;
  EXPECT_THROW(FindLogs({folder / "none.lcm"}), ConfigError);
  EXPECT_THROW(FindLogs({folder / ""}), ConfigError);  // a folder without logs
  std::ofstream(folder / "a.lcm") << "x";
  EXPECT_THAT(FindLogs({folder / "", folder / "a.lcm"}).logs, SizeIs(1));
}

}  // namespace
}  // namespace sprout::batch
