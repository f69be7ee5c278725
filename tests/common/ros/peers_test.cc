// Against other people's readers and writers, see peers/with_peers.
#include <gmock/gmock.h>

#include <cstdlib>
#include <fstream>

#include "common/app/process.h"
#include "common/ros/frame_topics.h"
#include "common/ros/mcap_reader.h"
#include "tests/common/ros/ros_examples.h"
#include "tests/services/tools/log/graph_log.h"

namespace sprout {
namespace {

using examples::Json;

// Runs peers.mjs. @returns what it wrote to stdout and stderr; empty when all went well.
std::string RunPeer(std::vector<std::string> arguments) {
  const char* const folder = std::getenv("SPROUT_PEERS");
  if (folder == nullptr) return "SPROUT_PEERS is not set: run by peers/with_peers";
  std::vector<std::string> command = {"node", std::string(folder) + "/peers.mjs"};
  command.insert(command.end(), arguments.begin(), arguments.end());
  Process process(command);
  const std::optional<int> code = process.Wait(std::chrono::seconds(60));
  return code == 0 ? ""
                   : "exit code " + std::to_string(code.value_or(-1)) + ": " + process.Output();
}

std::string Base64(const std::vector<uint8_t>& bytes) {
  constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (size_t i = 0; i < bytes.size(); i += 3) {
    uint32_t three = uint32_t{bytes[i]} << 16;
    if (i + 1 < bytes.size()) three |= uint32_t{bytes[i + 1]} << 8;
    if (i + 2 < bytes.size()) three |= bytes[i + 2];
    for (size_t k = 0; k < 4; ++k) {
      text += i + k > bytes.size() ? '=' : kDigits[three >> (18 - 6 * k) & 63];
    }
  }
  return text;
}

Json ReadJson(const std::string& path) {
  std::ifstream file(path);
  return Json::parse(file);
}

TEST(RosPeers, DecodeEveryMessageAndEncodeItToTheSameBytes) {
  const TemporaryDirectory folder;
  Json messages = Json::array();
  std::vector<uint8_t> cdr;
  examples::ForEachRosExample([&](const auto& message, const Json& value) {
    WriteCdr(message, cdr);
    messages.push_back({{"type", message.type().name},
                        {"schema", RosSchema(message.type())},
                        {"cdr", Base64(cdr)},
                        {"value", value}});
  });
  std::ofstream(folder / "in") << messages;
  ASSERT_EQ(RunPeer({"cdr", folder / "in", folder / "out"}), "");
  const Json answers = ReadJson(folder / "out");
  ASSERT_EQ(answers.size(), messages.size());
  for (size_t i = 0; i < answers.size(); ++i) {
    EXPECT_EQ(answers[i]["difference"], "") << messages[i]["type"];
    EXPECT_EQ(answers[i]["cdr"], messages[i]["cdr"]) << messages[i]["type"];
  }
}

TEST(RosPeers, HashEveryTypeAsRosDoes) {
  const TemporaryDirectory folder;
  Json types = Json::array();
  for (const RosType* type : RosTypes()) {
    types.push_back({{"type", type->name}, {"schema", RosSchema(*type)}});
  }
  std::ofstream(folder / "in") << types;
  ASSERT_EQ(RunPeer({"hash", folder / "in", folder / "out"}), "");
  const Json hashes = ReadJson(folder / "out");
  ASSERT_EQ(hashes.size(), RosTypes().size());
  for (size_t i = 0; i < hashes.size(); ++i) {
    EXPECT_EQ(hashes[i], RosTypes()[i]->hash) << RosTypes()[i]->name;
  }
}

TEST(McapPeers, ReadEveryMessageOfAnExport) {
  const log::LogFolder folder;
  constexpr int kFrames = 30;
  const auto graph = log::GraphEvents(kFrames);
  const std::string file = folder.Write("log", graph);
  const std::string mcap = folder.File("out.mcap");
  const MainOutcome outcome = log::RunLog({"export", "--mcap", mcap, file});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  ASSERT_EQ(RunPeer({"read", mcap, folder.File("out")}), "");
  const Json read = ReadJson(folder.File("out"));
  // What it should be, from the log's events.
  const sprout::Rig rig = log::LogRig();
  std::vector<uint8_t> cdr;
  Json expected = Json::array();
  int latched = 0;
  for (const Event& event : ReadLog(file).events) {
    const auto add = [&](const RosTopicRow& row, int64_t seq, const AnyRosMessage& message) {
      WriteCdr(message, cdr);
      expected.push_back({RosTopicName(row, "/sprout"), row.type().name, event.utime * 1000, seq,
                          cdr.size(), Crc32(0, cdr)});
    };
    if (event.channel == kStatusChannel) {
      const StageStatus status = *DecodeStatus(event.data);
      add(RowOf(RosTopic::kDiagnostics), status.newest_frame.seq,
          ToRosDiagnostics(event.utime, {{status.stage, {status}}}));
      continue;
    }
    const auto part = PartOf(event.channel);
    if (!part || (part == Part::kRig && latched++ > 0)) continue;
    const DecodedPart decoded = *DecodePart(*part, event.data);
    for (const RosTopicRow& row : RosTopicRows()) {
      if (row.part != *part || row.topic == RosTopic::kDiagnostics) continue;
      const auto message = ToRos(row.topic, decoded.id, decoded.value, &rig, {});
      if (message) add(row, decoded.id.seq, *message);
    }
  }
  EXPECT_EQ(read["streamed"], expected);
  EXPECT_EQ(read["statistics"]["messages"], expected.size());
  EXPECT_EQ(read["statistics"]["counts"]["/sprout/disparity"], kFrames);
  EXPECT_EQ(read["done"], true);
  EXPECT_NE(read["dataCrc"], 0);
  Json indexed = read["indexed"];  // by time, and the log's times are not in order
  Json streamed = read["streamed"];
  std::sort(indexed.begin(), indexed.end());
  std::sort(streamed.begin(), streamed.end());
  EXPECT_EQ(indexed, streamed);
}

// What peers.mjs writes as message i.
std::vector<uint8_t> PeerData(uint32_t i) {
  std::vector<uint8_t> data(37 * i);
  for (uint32_t k = 0; k < data.size(); ++k) data[k] = static_cast<uint8_t>(i * 7 + k * (k % 3));
  return data;
}

TEST(McapPeers, AreReadHoweverTheyWrite) {
  const TemporaryDirectory folder;
  for (const char* kind : {"plain", "zstd", "lz4", "unchunked", "bare"}) {
    const std::string file = folder / (std::string(kind) + ".mcap").c_str();
    ASSERT_EQ(RunPeer({"write", file, kind}), "") << kind;
    McapReader reader(file);
    uint32_t count = 0;
    for (McapMessage message; reader.Next(message); ++count) {
      constexpr const char* kTopics[] = {"/a", "/b", "/none"};
      EXPECT_EQ(message.channel->topic, kTopics[count % 3]);
      EXPECT_EQ(message.channel->metadata.at("of"), kTopics[count % 3]);
      EXPECT_EQ(message.schema == nullptr, count % 3 == 2);
      EXPECT_EQ(message.sequence, count);
      EXPECT_EQ(message.log_time_ns, 1000 + count);
      EXPECT_EQ(message.publish_time_ns, 500 + count);
      EXPECT_EQ(std::vector(message.data.begin(), message.data.end()), PeerData(count));
    }
    EXPECT_EQ(count, 60U) << kind;
    EXPECT_THAT(reader.trouble(), testing::IsEmpty()) << kind;
    EXPECT_EQ(reader.chunks() > 5, std::string(kind) != "unchunked" && std::string(kind) != "bare");
    EXPECT_EQ(reader.Metadata().at("who").at("wrote"), "peer") << kind;
  }
}

}  // namespace
}  // namespace sprout
