#include <gmock/gmock.h>

#include <fstream>

#include "common/config/config_error.h"
#include "common/logfile/log_error.h"
#include "common/logfile/log_writer.h"
#include "common/messages/codec.h"
#include "services/tools/batch/log_task.h"
#include "services/tools/batch/measures.h"
#include "services/tools/batch/planning.h"
#include "services/tools/batch/report.h"
#include "services/tools/batch/result_folder.h"
#include "tests/common/picture/temporary_directory.h"
#include "tests/common/testing/thrown.h"
#include "tests/services/tools/batch/example_manifest.h"
#include "tests/services/tools/log/graph_log.h"

namespace sprout::batch {
namespace {

using testing::HasSubstr;
using testing::SizeIs;

TEST(Tables, AreReadAsTheyWereWritten) {
  const TemporaryDirectory folder;
  const Table table{
      .columns = {"seq", "utime", "left_at", "x"},
      .rows = {{1, 1700000000123456, 1'000'000'000'000, std::nullopt}, {2, 3, std::nullopt, 0.25}}};
  WriteTable(folder / "t.csv", table);
  const Table read = ReadTable(folder / "t.csv", {"x"});
  EXPECT_EQ(read.columns, table.columns);
  EXPECT_EQ(read.rows, table.rows);
}

// The answers to one frame.
std::unique_ptr<FrameLookup> Answers(const std::filesystem::path& log, const DisparityImage& map) {
  LogWriter writer(log);
  writer.Write(1, ChannelOf(Part::kDisparity),
               EncodePart(log::LogFrameId(7), Part::kDisparity, map));
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
      CompareFrames(*Answers(folder / "a", a), *Answers(folder / "b", b), Part::kDisparity);
  ASSERT_THAT(table.rows, SizeIs(1));
  EXPECT_THAT(table.rows[0], testing::ElementsAre(7, log::LogFrameId(7).utime, std::nullopt, 0.4,
                                                  0.2, 1.5, 3, 0, 0.1));
}

TEST(StageRuns, AreWhatAReplayReports) {
  const std::optional<StageRun> run = ParseReplayReport(
      "warning\ngrow: 414 events; frames: 45 in, 44 out (2 degenerate), 1 failed, 3 incomplete, 6 "
      "left out; 5 bad messages, 7 damaged bytes; 1.49 s, 30.2 frames/s\n");
  ASSERT_TRUE(run);
  EXPECT_EQ(run->frames_in(), 45);
  EXPECT_EQ(run->frames_out(), 44);
  EXPECT_EQ(run->degenerate(), 2);
  EXPECT_EQ(run->failed(), 1);
  EXPECT_EQ(run->incomplete(), 3);
  EXPECT_EQ(run->left_out(), 6);
  EXPECT_EQ(run->bad_messages(), 5);
  EXPECT_EQ(run->damaged_bytes(), 7);
  EXPECT_EQ(ParseReplayReport("no report"), std::nullopt);
}

TEST(LogTry, LeavesAFileOfEachTryThatDidNotSucceed) {
  const TemporaryDirectory folder;
  const BatchFolder batch(folder / "");
  { const LogTry attempt(batch, 7); }
  EXPECT_THAT(FailedTries(batch), testing::IsEmpty());
  {
    LogTry attempt(batch, 7);
    attempt.Fail("first");
    attempt.Fail("a consequence");
  }
  const LogTry at_work(batch, 7);
  EXPECT_EQ(FailedTries(batch), (std::map<int, int>{{7, 2}}));
  EXPECT_EQ(FirstLineOf(TryPath(batch, 7, 1)), "first");
  ForgetTry(batch, 7);
  EXPECT_EQ(FailedTries(batch), (std::map<int, int>{{7, 1}}));
}

// The folder `failed` may hold files of the user's as well.
TEST(LogTry, ForgettingAllLeavesWhatIsNone) {
  const TemporaryDirectory folder;
  const BatchFolder batch(folder / "");
  LogTry(batch, 12).Fail("why");
  for (const char* name : {"1.lcm", "notes.txt", "12.b.txt"}) {
    std::ofstream(batch.failures() / name) << "mine";
  }
  ForgetTries(batch);
  EXPECT_FALSE(std::filesystem::exists(TryPath(batch, 12, 1)));
  for (const char* name : {"1.lcm", "notes.txt", "12.b.txt"}) {
    EXPECT_TRUE(std::filesystem::exists(batch.failures() / name)) << name;
  }
}

// Three logs: x is done at the second try, y failed for good, z was not tried.
class LossesOfABatch : public testing::Test {
 protected:
  void SetUp() override {
    manifest_.mutable_variant()->RemoveLast();
    BatchLog& log = *manifest_.add_log();
    log.set_name("z");
    log.set_digest(Digest("z"));
    StageRuns runs;
    ParseText(
        "run { frames_in: 20 frames_out: 20 incomplete: 3 left_out: 4 bad_messages: 2"
        "      damaged_bytes: 600 }"
        "run { frames_in: 20 frames_out: 18 degenerate: 1 bad_messages: 1 seconds: 0.5 }",
        "runs", runs);
    ResultFolder result(batch_.result(manifest_, 0, 0));
    WriteText(result / kRuns, ConfigText(runs));
    result.Commit();
    LogTry(batch_, 0).Fail("out of <luck>");
    for (int i = 0; i < 2; ++i) LogTry(batch_, 1).Fail("broken");
    state_ = StateOf(batch_, manifest_);
  }

  TemporaryDirectory folder_;
  BatchFolder batch_{folder_ / ""};
  Manifest manifest_ = ExampleManifest();
  BatchState state_;
};

TEST_F(LossesOfABatch, StandInTheReportPerLogAndInAll) {
  EXPECT_EQ(state_.missing, 2);
  const auto bad = [](int n) { return "<td class=\"bad\">" + std::to_string(n) + "</td>"; };
  const std::string none = "<td class=\"none\">0</td>";
  const std::string counts = bad(2) + bad(1) + bad(2) + bad(3) + bad(4) + bad(600) + "</tr>";
  const std::string html = LossesHtml(batch_, manifest_, state_);
  EXPECT_THAT(html, HasSubstr("<tr><td>all 3 logs</td><td>3</td>" + bad(1) + bad(1) + bad(1) +
                              "<td>20</td>" + counts));
  EXPECT_THAT(
      html, HasSubstr("<tr><td>x</td><td>1</td>" + bad(1) + none + none + "<td>20</td>" + counts));
  EXPECT_THAT(html, HasSubstr("<tr><td>y</td><td>1</td>" + none + bad(1) + none));
  EXPECT_THAT(html, HasSubstr("<tr><td>z</td><td>1</td>" + none + none + bad(1)));
  EXPECT_THAT(html, HasSubstr("<td>y</td><td>missing after 2 failed tries"));
  EXPECT_THAT(html, HasSubstr("<td>x</td><td>done after 1 failed try"));
  EXPECT_THAT(html, HasSubstr("failed/0.1.txt\">out of &lt;luck&gt;<"));
}

TEST_F(LossesOfABatch, AreRefusedWhenTheyLackAStageOrCannotBe) {
  const auto result = folder_ / "result";
  std::filesystem::create_directory(result);
  const auto error_of = [&](const std::string& text) {
    WriteText(result / kRuns, text);
    return Thrown<LogError>([&] { ReadStageRuns(result, manifest_); });
  };
  EXPECT_EQ(error_of("run { frames_in: 3 } run { }"), "no error");
  EXPECT_THAT(error_of("run { frames_in: 3 }"), HasSubstr("runs.textproto: lacks the counts"));
  EXPECT_THAT(error_of("run { frames_in: -3 } run { }"), HasSubstr("count that is not possible"));
  EXPECT_THAT(error_of("run { seconds: nan } run { }"), HasSubstr("count that is not possible"));
  EXPECT_THAT(error_of("run {"), HasSubstr("runs.textproto: counts:"));
}

TEST(FindLogs, RefusesWhatIsNotThere) {
  const TemporaryDirectory folder;
  EXPECT_THROW(FindLogs({folder / "none.lcm"}), ConfigError);
  EXPECT_THROW(FindLogs({folder / ""}), ConfigError);  // a folder without logs
  std::ofstream(folder / "a.lcm") << "x";
  EXPECT_THAT(FindLogs({folder / "", folder / "a.lcm"}), SizeIs(1));
  std::filesystem::create_symlink("a.lcm", folder / "latest.lcm");
  EXPECT_THAT(FindLogs({folder / "a.lcm", folder / "latest.lcm"}), SizeIs(1));
}

}  // namespace
}  // namespace sprout::batch
