#include <gmock/gmock.h>
#include <zstd.h>

#include <fstream>
#include <memory>

#include "common/ros/chunk_codec.h"
#include "common/ros/mcap_reader.h"
#include "common/ros/mcap_writer.h"
#include "tests/common/logfile/sample_log.h"
#include "tests/common/testing/test_with_folder.h"

namespace sprout {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr size_t kMessageBytes = 100;

// Messages that hold their time, one topic behind the other, some in each chunk.
void WriteTopicByTopic(const fs::path& path, const std::vector<std::vector<uint64_t>>& topics,
                       size_t chunk_bytes = 500) {
  McapWriter writer(path, {.profile = "ros2", .chunk_bytes = chunk_bytes});
  const uint16_t schema = writer.AddSchema("a/msg/B", "ros2msg", "string data\n");
  for (size_t i = 0; i < topics.size(); ++i) {
    const uint16_t channel = writer.AddChannel(schema, "/topic" + std::to_string(i), "cdr");
    for (const uint64_t time : topics[i]) {
      writer.Write(channel, 0, time, Bytes(kMessageBytes, static_cast<uint8_t>(time)));
    }
  }
  EXPECT_TRUE(writer.Commit());
}

struct Read {
  std::vector<uint64_t> times;
  std::vector<std::string> topics;
};

Read ReadAll(McapReader& reader) {
  Read read;
  for (McapMessage message; reader.Next(message);) {
    read.times.push_back(message.log_time_ns);
    read.topics.push_back(message.channel->topic);
    EXPECT_EQ(Bytes(message.data.begin(), message.data.end()),
              Bytes(kMessageBytes, static_cast<uint8_t>(message.log_time_ns)));
  }
  EXPECT_LE(reader.position(), reader.size());
  return read;
}

std::vector<uint64_t> Times(uint64_t begin, uint64_t end, uint64_t step) {
  std::vector<uint64_t> times;
  for (uint64_t time = begin; time < end; time += step) times.push_back(time);
  return times;
}

class McapOrderTest : public TestWithFolder {};

TEST_F(McapOrderTest, IsThatOfTheLogTimes) {
  // Odd ones behind even ones, and one topic backwards.
  std::vector<uint64_t> backwards = Times(202, 240, 3);
  std::ranges::reverse(backwards);
  WriteTopicByTopic(folder_ / "file", {Times(0, 200, 2), Times(1, 200, 2), backwards});
  McapReader reader(folder_ / "file");
  const Read read = ReadAll(reader);
  EXPECT_EQ(read.times.size(), 200 + backwards.size());
  EXPECT_TRUE(std::ranges::is_sorted(read.times));
  for (size_t i = 0; i < 200; ++i) EXPECT_EQ(read.topics[i], i % 2 == 0 ? "/topic0" : "/topic1");
  EXPECT_THAT(reader.trouble(), IsEmpty());
  EXPECT_GT(reader.chunks(), 40);
}

TEST_F(McapOrderTest, OfOneTimeIsThatOfTheFile) {
  WriteTopicByTopic(folder_ / "file", {{7, 7, 7}, {7, 7, 7}, {7}}, 100);
  McapReader reader(folder_ / "file");
  EXPECT_THAT(ReadAll(reader).topics, ElementsAre("/topic0", "/topic0", "/topic0", "/topic1",
                                                  "/topic1", "/topic1", "/topic2"));
}

// Chunks that all overlap do not all stay in memory.
TEST_F(McapOrderTest, IsTheSameWithLittleMemory) {
  std::vector<std::vector<uint64_t>> topics;
  for (uint64_t i = 0; i < 20; ++i) topics.push_back(Times(i, 200, 20));
  WriteTopicByTopic(folder_ / "file", topics, 2000);
  McapReader reader({fs::path(folder_ / "file")}, /*most_unpacked_bytes=*/3000);
  EXPECT_EQ(ReadAll(reader).times, Times(0, 200, 1));
  EXPECT_THAT(reader.trouble(), IsEmpty());
}

TEST_F(McapOrderTest, IsThatOfAllParts) {
  fs::create_directory(folder_ / "bag");
  WriteTopicByTopic(folder_ / "bag/bag_0.mcap", {Times(0, 100, 2)});
  WriteTopicByTopic(folder_ / "bag/bag_1.mcap", {Times(100, 200, 2), Times(1, 200, 2)});
  std::ofstream(folder_ / "bag/._bag_0.mcap") << "Mac OS X";
  const std::string bag = folder_ / "bag";
  for (const std::string& name : {bag, bag + "/bag_1.mcap," + bag + "/bag_0.mcap"}) {
    McapReader reader(McapParts(name));
    EXPECT_EQ(ReadAll(reader).times, Times(0, 200, 1)) << name;
    EXPECT_TRUE(reader.has_ended());
    EXPECT_THAT(reader.Topics(), ElementsAre(McapTopic{"/topic0", "a/msg/B", "cdr"},
                                             McapTopic{"/topic1", "a/msg/B", "cdr"}));
  }
  // Of two parts trouble says which one has it.
  Bytes torn = ReadBytes(folder_ / "bag/bag_1.mcap");
  torn.resize(torn.size() / 2);
  WriteBytes(folder_ / "bag/bag_1.mcap", torn);
  McapReader reader(McapParts(bag));
  EXPECT_GT(ReadAll(reader).times.size(), 50U);
  EXPECT_THAT(reader.trouble(), ElementsAre(HasSubstr("bag_1.mcap: byte ")));
}

void Pack(const fs::path& from, const fs::path& to) {
  const Bytes bytes = ReadBytes(from);
  Bytes packed(ZSTD_compressBound(bytes.size()));
  packed.resize(ZSTD_compress(packed.data(), packed.size(), bytes.data(), bytes.size(), 3));
  WriteBytes(to, packed);
}

class McapPartsTest : public TestWithFolder {};

TEST_F(McapPartsTest, AreThoseThatMetadataNames) {
  WriteTopicByTopic(folder_ / "bag_0.mcap", {Times(0, 100, 1)});
  WriteTopicByTopic(folder_ / "bag_1.mcap", {Times(100, 200, 1)});
  WriteTopicByTopic(folder_ / "another.mcap", {Times(0, 5, 1)});
  std::ofstream(folder_ / "metadata.yaml")
      << "rosbag2_bagfile_information:\n  version: 5\n  storage_identifier: mcap\n"
         "  relative_file_paths:\n    - bag_0.mcap.zstd\n    - bag_1.mcap.zstd\n"
         "  compression_format: zstd\n  compression_mode: FILE\n";
  // One is packed, one was unpacked by a player.
  Pack(folder_ / "bag_0.mcap", folder_ / "bag_0.mcap.zstd");
  fs::remove(folder_ / "bag_0.mcap");
  McapReader reader(McapParts((folder_ / "").string()));
  EXPECT_EQ(ReadAll(reader).times, Times(0, 200, 1));
  const std::string metadata = folder_ / "metadata.yaml";
  EXPECT_EQ(McapParts(metadata), McapParts((folder_ / "").string()));
  fs::remove(folder_ / "bag_1.mcap");
  EXPECT_THAT([&] { McapParts((folder_ / "").string()); },
              testing::ThrowsMessage<ConfigError>(
                  HasSubstr("metadata.yaml names bag_1.mcap.zstd, which is not there")));
}

TEST_F(McapPartsTest, OfAFilePackedAsAWholeAreAllThatIsWhole) {
  WriteTopicByTopic(folder_ / "file", {Times(0, 20000, 1)}, 5000);
  Pack(folder_ / "file", folder_ / "file.mcap.zstd");
  McapReader reader(fs::path(folder_ / "file.mcap.zstd"));
  EXPECT_EQ(ReadAll(reader).times, Times(0, 20000, 1));
  EXPECT_THAT(reader.trouble(), IsEmpty());
  Bytes torn = ReadBytes(folder_ / "file.mcap.zstd");
  torn.resize(torn.size() / 2);
  WriteBytes(folder_ / "file.mcap.zstd", torn);
  McapReader torn_reader(fs::path(folder_ / "file.mcap.zstd"));
  EXPECT_GT(ReadAll(torn_reader).times.size(), 100U);
  EXPECT_THAT(torn_reader.trouble(), testing::Contains(HasSubstr("the packed file ends")));
}

TEST_F(McapPartsTest, OfAFilePackedAsAWholeMayHaveAnySize) {
  WriteTopicByTopic(folder_ / "file", {Times(0, 2000, 1)}, 5000);
  const Bytes bytes = ReadBytes(folder_ / "file");
  // An unknown record behind the magic makes it as long as whole blocks of zstd.
  constexpr size_t kMagic = 8;
  constexpr size_t kHead = 9;
  const size_t block = ZSTD_DStreamOutSize();
  const size_t more = block - (bytes.size() + kHead) % block;
  Bytes padded(bytes.begin(), bytes.begin() + kMagic);
  padded.push_back(0x80);
  for (size_t i = 0; i < 8; ++i) padded.push_back(static_cast<uint8_t>(more >> (8 * i)));
  padded.resize(padded.size() + more);
  padded.insert(padded.end(), bytes.begin() + kMagic, bytes.end());
  ASSERT_EQ(padded.size() % block, 0U);
  WriteBytes(folder_ / "padded", padded);
  Pack(folder_ / "padded", folder_ / "file.mcap.zstd");
  McapReader reader(fs::path(folder_ / "file.mcap.zstd"));
  EXPECT_EQ(ReadAll(reader).times, Times(0, 2000, 1));
  EXPECT_THAT(reader.trouble(), IsEmpty());
}

TEST_F(McapPartsTest, OfOtherBagsSayWhatMakesMcapOfThem) {
  fs::create_directory(folder_ / "bag");
  std::ofstream(folder_ / "bag/bag_0.db3") << "SQLite format 3";
  EXPECT_THAT(
      [&] { McapParts((folder_ / "bag").string()); },
      testing::ThrowsMessage<ConfigError>(HasSubstr("SQLite; make MCAP of it with ros2 bag")));
  EXPECT_THAT([&] { McapReader(fs::path(folder_ / "bag/bag_0.db3")); },
              testing::ThrowsMessage<ConfigError>(HasSubstr("no MCAP file: a bag in SQLite")));
  std::ofstream(folder_ / "a.bag") << "#ROSBAG V2.0\n";
  EXPECT_THAT([&] { McapReader(fs::path(folder_ / "a.bag")); },
              testing::ThrowsMessage<ConfigError>(HasSubstr("rosbags-convert")));
  std::ofstream(folder_ / "a.mcap.lz4") << "\x04\x22\x4d\x18 and more";
  EXPECT_THAT([&] { McapReader(fs::path(folder_ / "a.mcap.lz4")); },
              testing::ThrowsMessage<ConfigError>(HasSubstr("packed with lz4; unpack it")));
  std::ofstream(folder_ / "a.mcap.gz") << "\x1f\x8b\x08 and more";
  EXPECT_THAT([&] { McapReader(fs::path(folder_ / "a.mcap.gz")); },
              testing::ThrowsMessage<ConfigError>(HasSubstr("packed with gzip; unpack it")));
  WriteBytes(folder_ / "packed.mcap.zstd", Bytes());
  Pack(folder_ / "a.bag", folder_ / "packed.mcap.zstd");
  EXPECT_THAT([&] { McapReader(fs::path(folder_ / "packed.mcap.zstd")); },
              testing::ThrowsMessage<ConfigError>(HasSubstr("no MCAP file in it: a bag of ROS 1")));
  fs::remove(folder_ / "bag/bag_0.db3");
  std::ofstream(folder_ / "bag/bag_0.db3.zstd") << "packed";
  const auto is_sqlite = testing::ThrowsMessage<ConfigError>(HasSubstr("a bag in SQLite"));
  EXPECT_THAT([&] { McapParts((folder_ / "bag").string()); }, is_sqlite);
  std::ofstream(folder_ / "bag/metadata.yaml")
      << "rosbag2_bagfile_information:\n  relative_file_paths:\n    - bag_0.db3.zstd\n";
  EXPECT_THAT([&] { McapParts((folder_ / "bag").string()); }, is_sqlite);
}

TEST(McapMessages, ThatArePackedByThemselvesComeOut) {
  // Longer than what memory grows by.
  Bytes message(9'000'000, uint8_t{3});
  for (size_t i = 0; i < message.size(); i += 7) message[i] = static_cast<uint8_t>(i * i >> 5);
  const std::unique_ptr<ZSTD_CCtx, decltype(&ZSTD_freeCCtx)> context(ZSTD_createCCtx(),
                                                                     &ZSTD_freeCCtx);
  for (const int says_its_size : {0, 1}) {
    ZSTD_CCtx_setParameter(context.get(), ZSTD_c_contentSizeFlag, says_its_size);
    Bytes packed(ZSTD_compressBound(message.size()));
    packed.resize(ZSTD_compress2(context.get(), packed.data(), packed.size(), message.data(),
                                 message.size()));
    EXPECT_TRUE(IsZstd(packed));
    const Result<McapBytes> unpacked = UnpackMessage(packed);
    ASSERT_TRUE(unpacked) << unpacked.error().text;
    EXPECT_TRUE(*unpacked == message);
    packed.push_back(0);
    EXPECT_THAT(UnpackMessage(packed).error().text, HasSubstr("message: bytes behind"));
    packed.resize(packed.size() / 2);
    EXPECT_THAT(UnpackMessage(packed).error().text, HasSubstr("message: cannot be unpacked"));
  }
  EXPECT_FALSE(IsZstd(message));
}

}  // namespace
}  // namespace sprout
