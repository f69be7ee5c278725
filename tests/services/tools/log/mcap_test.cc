#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "common/ros/mcap_reader.h"
#include "tests/services/tools/log/graph_log.h"

namespace sprout::log {
namespace {

using testing::HasSubstr;

std::map<std::string, int> CountTopics(const std::string& file) {
  McapReader reader(file);
  std::map<std::string, int> counts;
  for (McapMessage message; reader.Next(message);) ++counts[message.channel->topic];
  EXPECT_THAT(reader.trouble(), testing::IsEmpty());
  return counts;
}

const std::map<std::string, int> kTwelveFrames = {{"/diagnostics", 12},
                                                  {"/sprout/disparity", 12},
                                                  {"/sprout/left/camera_info", 12},
                                                  {"/sprout/left/image_rect", 12},
                                                  {"/sprout/right/camera_info", 12},
                                                  {"/sprout/right/image_rect", 12},
                                                  {"/sprout/tof/amplitude", 12},
                                                  {"/sprout/tof/camera_info", 12},
                                                  {"/sprout/tof/image_raw", 12},
                                                  {"/tf_static", 1}};

class McapExport : public TestWithLogs {};

TEST_F(McapExport, HasEveryMessageOfTheLogAndNothingButCdr) {
  const std::string log = folder_.Write("log", GraphEvents(12));
  const std::string out = OutOf({"export", "--mcap", folder_.File("out"), log});
  EXPECT_EQ(out, folder_.File("out") + ": 109 messages\n");
  EXPECT_EQ(CountTopics(folder_.File("out")), kTwelveFrames);
  McapReader reader(folder_.File("out"));
  for (McapMessage message; reader.Next(message);) {
    ASSERT_NE(message.schema, nullptr);
    EXPECT_EQ(message.schema->encoding, "ros2msg");
    EXPECT_EQ(message.channel->encoding, "cdr");
  }
  EXPECT_EQ(reader.profile(), "ros2");
}

// The calibration of frame 0 stands behind it.
TEST_F(McapExport, KeepsTheFramesThatAreAskedFor) {
  const std::string log = folder_.Write("log", GraphEvents(12));
  RunLog({"export", "--mcap", folder_.File("out"), log, "--frames", "3:5"});
  const auto counts = CountTopics(folder_.File("out"));
  EXPECT_EQ(counts.at("/sprout/disparity"), 3);
  EXPECT_EQ(counts.at("/sprout/left/camera_info"), 3);
  EXPECT_EQ(counts.at("/diagnostics"), 3);
  EXPECT_EQ(counts.at("/tf_static"), 1);
}

TEST_F(McapExport, NamesTheChannelsOfAnotherPrefix) {
  const std::string log = folder_.Write("log", GraphEvents(1));
  ExpectRefused({"export", "--mcap", folder_.File("out"), log, "--channel-prefix", "B_"},
                "there are channels as SPROUT_");
}

TEST_F(McapExport, GivesWhatIsWholeOfADamagedLog) {
  Bytes bytes;
  {
    std::vector<Event> events = GraphEvents(12);
    bytes = MakeLog(events);
    const Event& left = EventOf(events, Part::kLeft, 4);
    std::fill_n(bytes.begin() + left.offset + 2, 20, uint8_t{0});
  }
  WriteBytes(folder_.File("log"), bytes);
  const MainOutcome outcome =
      RunLog({"export", "--mcap", folder_.File("out"), folder_.File("log")});
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_THAT(outcome.err, HasSubstr("damage"));
  auto expected = kTwelveFrames;
  --expected["/sprout/left/image_rect"];
  --expected["/sprout/left/camera_info"];
  EXPECT_EQ(CountTopics(folder_.File("out")), expected);
}

TEST_F(McapExport, SaysWhatHasNoCalibration) {
  std::vector<Event> events = GraphEvents(2);
  Erase(events, Part::kRig, 1);
  const std::string log = folder_.Write("log", events);
  const MainOutcome outcome = RunLog({"export", "--mcap", folder_.File("out"), log});
  EXPECT_THAT(outcome.err, HasSubstr("8 messages whose calibration is not in the log"));
  EXPECT_FALSE(CountTopics(folder_.File("out")).contains("/sprout/disparity"));
}

TEST_F(McapExport, HasTheConfigurationsAsMetadata) {
  std::vector<Event> events = GraphEvents(1);
  ProcessInfo info;
  info.stage = "grow";
  info.config_text = "grow { }\n";
  Event event;
  event.utime = events[0].utime;
  event.channel = kProcessChannel;
  event.data = EncodeProcessInfo(info);
  events.push_back(event);
  const std::string log = folder_.Write("log", events);
  RunLog({"export", "--mcap", folder_.File("out"), log});
  McapReader reader(folder_.File("out"));
  for (McapMessage message; reader.Next(message);) {
  }
  EXPECT_EQ(reader.Metadata().at("sprout process grow").at("config"), "grow { }\n");
  EXPECT_THAT(RunLog({"info", "--config", folder_.File("out")}).out,
              HasSubstr("config: grow { }\n"));
}

TEST(McapInfo, RefusesAFolderThatIsNoBag) {
  const LogFolder folder;
  WriteBytes(folder.File("text"), Bytes(3));
  ExpectRefused({"info", folder.File("")}, "a folder without .mcap files; a log of LCM is");
}

TEST_F(McapExport, RefusesWhatItCannotDo) {
  const std::string log = folder_.Write("log", GraphEvents(1));
  WriteBytes(folder_.File("old"), Bytes(3));
  ExpectRefused({"export", "--mcap", folder_.File("old"), log}, "exists already; --force");
  EXPECT_EQ(ReadBytes(folder_.File("old")), Bytes(3));
  EXPECT_EQ(RunLog({"export", "--mcap", folder_.File("old"), log, "--force"}).exit_code, 0);
  ExpectRefused({"export", "--mcap", folder_.File("no"), log, "--frames", "7:9"}, "no message");
  EXPECT_FALSE(std::filesystem::exists(folder_.File("no")));
  ExpectRefused({"export", log}, "DIR");
}

TEST(McapInfo, ListsTopicsTypesAndCounts) {
  const LogFolder folder;
  const std::string log = folder.Write("log", GraphEvents(12));
  RunLog({"export", "--mcap", folder.File("out"), log});
  const std::string outcome = OutOf({"info", folder.File("out"), "--check"});
  EXPECT_THAT(outcome, HasSubstr("MCAP (ros2) by sprout "));
  EXPECT_THAT(outcome, testing::ContainsRegex(
                           "/sprout/disparity +stereo_msgs/msg/DisparityImage +12 +10.00"));
  EXPECT_THAT(outcome, HasSubstr("no damage\n"));
  const auto json = nlohmann::json::parse(RunLog({"info", "--json", folder.File("out")}).out);
  EXPECT_EQ(json["messages"], 109);
  EXPECT_EQ(json["whole"], true);
  Bytes bytes = ReadBytes(folder.File("out"));
  bytes.resize(bytes.size() / 2);
  WriteBytes(folder.File("torn"), bytes);
  EXPECT_THAT(OutOf({"info", folder.File("torn"), "--check"}, 1), HasSubstr("damage: byte "));
}

}  // namespace
}  // namespace sprout::log
