#include <nlohmann/json.hpp>

#include "tests/services/tools/log/graph_log.h"

namespace sprout::log {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

// A graph's log in which frame 2 has half a map and frame 4 none at all; frame 1 was not answered.
std::vector<Event> LogWithBadFrames() {
  std::vector<Event> events = GraphEvents(6);
  DisparityImage half = LogDisparity(2);
  half.counts().rowRange(0, half.height() / 2) = DisparityImage::kInvalid;
  EventOf(events, Part::kDisparity, 2) = PartEvent(Part::kDisparity, 2, half);
  EventOf(events, Part::kDisparity, 4) =
      PartEvent(Part::kDisparity, 4, DisparityImage(kLogImageSize));
  Erase(events, Part::kDisparity, 1);
  return events;
}

std::vector<int64_t> Order(const nlohmann::json& json) {
  std::vector<int64_t> order;
  for (const auto& frame : json["frames"]) order.push_back(frame["seq"]);
  return order;
}

class RankTest : public testing::Test {
 protected:
  LogFolder folder_;
  std::string log_ = folder_.Write("run.lcm", LogWithBadFrames());
};

TEST_F(RankTest, HasTheWorstFramesFirstAndThoseWithoutAMapLast) {
  const std::string out = OutOf({"rank", log_, "--json"});
  const auto json = nlohmann::json::parse(out);
  EXPECT_EQ(Order(json), (std::vector<int64_t>{4, 2, 0, 3, 5, 1}));
  const auto& worst = json["frames"][0];
  EXPECT_EQ(worst["utime"], LogFrameId(4).utime);
  EXPECT_EQ(worst["score"], 0);
  EXPECT_EQ(worst["seeds"], 2);
  EXPECT_TRUE(worst["misfit"].is_null());
  EXPECT_DOUBLE_EQ(json["frames"][1]["valid_share"], 28.0 / 32 / 2);
  EXPECT_TRUE(json["frames"][5]["score"].is_null());
}

TEST_F(RankTest, ShowsATableForPeople) {
  const std::string out = OutOf({"rank", log_, "--top", "2"});
  EXPECT_THAT(out, StartsWith("   frame         s     score  valid_share  confidence"));
  EXPECT_THAT(out, HasSubstr("\n       4     0.400     0.000        0.000           -"));
  EXPECT_THAT(out, HasSubstr("\n       2     0.200     0.438        0.438"));
  EXPECT_THAT(out, HasSubstr("... of 5 frames, the worst by score first"));
  EXPECT_THAT(out, HasSubstr("not ranked, without a score: 1 frames\n"));
}

TEST_F(RankTest, WritesARowAFrameInFullPrecision) {
  const std::string out = OutOf({"rank", log_, "--csv", "--frames", "0:2"});
  EXPECT_THAT(out, StartsWith("seq,utime,score,valid_share,confidence,misfit,seeds,"
                              "seeds_kept,tof_coverage\n2,1700000000200000,0.4375,0.4375,"
                              ",0,2,1,"));
  EXPECT_EQ(std::count(out.begin(), out.end(), '\n'), 4) << out;
  EXPECT_THAT(out, HasSubstr("\n1,1700000000100000,,,,,2,1,")) << "not answered";
}

TEST_F(RankTest, RanksByAnyColumn) {
  const MainOutcome outcome = RunLog({"rank", log_, "--json", "--by", "valid_share"});
  EXPECT_EQ(Order(nlohmann::json::parse(outcome.out)).front(), 4);
  ExpectRefused({"rank", log_, "--by", "beauty"}, "--by beauty: allowed: score, valid_share, ");
}

TEST_F(RankTest, WritesThePicturesOfTheWorst) {
  const std::string pictures = folder_.File("pictures");
  const MainOutcome outcome = RunLog({"rank", log_, "--top", "1", "--images", pictures});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_TRUE(std::filesystem::exists(pictures + "/000004_left.png"));
  EXPECT_TRUE(std::filesystem::exists(pictures + "/000004_disparity.png"));
  EXPECT_FALSE(std::filesystem::exists(pictures + "/000002_left.png"));
  EXPECT_THAT(outcome.err, HasSubstr("1 worst frames\n"));
  const MainOutcome again =
      RunLog({"rank", log_, "--top", "1", "--images", pictures, "--frames", "0:2"});
  EXPECT_THAT(again.err, HasSubstr(" files of other frames were there before\n"));
}

TEST_F(RankTest, KnowsTheFramesWhoseAnswersComeFromAnotherLog) {
  std::vector<Event> raw = LogWithBadFrames();
  std::vector<Event> answers;
  std::erase_if(raw, [&](const Event& event) {
    if (event.channel != ChannelOf(Part::kDisparity)) return false;
    answers.push_back(event);
    return true;
  });
  const std::string both = folder_.File("both.lcm");
  ASSERT_EQ(RunLog({"merge", folder_.Write("raw.lcm", raw), folder_.Write("answers.lcm", answers),
                    "--out", both})
                .exit_code,
            0);
  const auto frames = [](const std::string& out) { return nlohmann::json::parse(out)["frames"]; };
  EXPECT_EQ(frames(RunLog({"rank", both, "--json"}).out),
            frames(RunLog({"rank", log_, "--json"}).out));
}

TEST_F(RankTest, RefusesALogWithoutAnswers) {
  std::vector<Event> raw = GraphEvents(3);
  std::erase_if(raw,
                [](const Event& event) { return event.channel == ChannelOf(Part::kDisparity); });
  ExpectRefused({"rank", folder_.Write("raw.lcm", raw)}, "no frame with a score: allowed is a log");
  ExpectRefused({"rank", log_, "--channel-prefix", "B_"}, "see --channel-prefix");
  ExpectRefused({"rank", log_, "--csv", "--json"}, "excludes");
}

TEST(Rank, SaysThatScoresWithoutImagesAreOnAnotherScale) {
  const LogFolder folder;
  std::vector<Event> events;
  for (int seq = 0; seq < 3; ++seq) events.push_back(PartEvent(Part::kDisparity, seq));
  const MainOutcome alone = RunLog({"rank", folder.Write("alone", events)});
  EXPECT_EQ(alone.exit_code, 0) << alone.err;
  EXPECT_THAT(alone.err, testing::HasSubstr("3 of 3 frames have no images that fit the map"));
  EXPECT_EQ(RunLog({"rank", folder.Write("whole", GraphEvents(3))}).err, "");
}

}  // namespace
}  // namespace sprout::log
