#include <gmock/gmock.h>
#include <sys/resource.h>

#include <fstream>

#include "common/ros/mcap_reader.h"
#include "common/ros/mcap_writer.h"
#include "tests/common/logfile/sample_log.h"
#include "tests/common/ros/repacked.h"
#include "tests/common/testing/test_with_folder.h"

namespace sprout {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

struct Content {
  std::vector<std::pair<std::string, Bytes>> messages;
  std::vector<std::string> trouble;
};

Content ReadMcap(const std::filesystem::path& path) {
  McapReader reader(path);
  Content content;
  for (McapMessage message; reader.Next(message);) {
    content.messages.emplace_back(message.channel->topic,
                                  Bytes(message.data.begin(), message.data.end()));
  }
  content.trouble = reader.trouble();
  return content;
}

Bytes MessageData(int number) {
  Bytes data(static_cast<size_t>(number * 53 % 997));
  for (size_t i = 0; i < data.size(); ++i) {
    data[i] = static_cast<uint8_t>(static_cast<size_t>(number) + i * (i % 5));
  }
  return data;
}

// 120 messages on two topics, and one metadata in the middle.
Bytes MakeMcap(const TemporaryDirectory& folder, std::string_view compression = "zstd") {
  McapWriter writer(folder / "made", {.profile = "test", .library = "ours", .chunk_bytes = 4000});
  const uint16_t schema = writer.AddSchema("a/msg/B", "ros2msg", "string data\n");
  const uint16_t first = writer.AddChannel(schema, "/first", "cdr", {{"key", "value"}});
  const uint16_t second = writer.AddChannel(0, "/second", "cdr");
  for (int i = 0; i < 120; ++i) {
    writer.Write(i % 3 == 0 ? second : first, static_cast<uint32_t>(i), 1000U + i, MessageData(i));
    if (i == 60) writer.AddMetadata("who", {{"a", "b"}});
  }
  EXPECT_TRUE(writer.Commit());
  const Bytes file = Repacked(ReadBytes(folder / "made"), compression);
  WriteBytes(folder / "made", file);
  return file;
}

constexpr std::string_view kCompressions[] = {"", "zstd", "lz4"};

class McapTest : public TestWithFolder {};

TEST_F(McapTest, GivesBackWhatWasWritten) {
  for (const std::string_view compression : kCompressions) {
    MakeMcap(folder_, compression);
    McapReader reader(folder_ / "made");
    int count = 0;
    for (McapMessage message; reader.Next(message); ++count) {
      EXPECT_EQ(message.channel->topic, count % 3 == 0 ? "/second" : "/first");
      EXPECT_EQ(message.schema == nullptr, count % 3 == 0);
      EXPECT_EQ(message.log_time_ns, 1000U + count);
      EXPECT_EQ(Bytes(message.data.begin(), message.data.end()), MessageData(count));
    }
    EXPECT_EQ(count, 120);
    EXPECT_TRUE(reader.has_ended());
    EXPECT_GT(reader.chunks(), 10);
    EXPECT_THAT(reader.trouble(), IsEmpty());
    EXPECT_EQ(reader.Metadata().at("who").at("a"), "b");
    EXPECT_EQ(reader.profile(), "test");
  }
}

TEST_F(McapTest, TheSameMessagesGiveTheSameBytes) {
  EXPECT_EQ(MakeMcap(folder_), MakeMcap(folder_));
}

// Where records of the outer level begin, by opcode and length alone.
std::vector<std::pair<McapOpcode, size_t>> Borders(const Bytes& file) {
  std::vector<std::pair<McapOpcode, size_t>> borders;
  size_t at = kMcapMagic.size();
  while (at + kRecordHead <= file.size() - kMcapMagic.size()) {
    borders.emplace_back(static_cast<McapOpcode>(file[at]), at);
    uint64_t size = 0;
    std::memcpy(&size, file.data() + at + 1, sizeof size);
    at += kRecordHead + size;
  }
  return borders;
}

// Of a file that was torn off, every message of its whole chunks is there, and one line says so.
TEST_F(McapTest, GivesAllThatIsWholeOfATornFile) {
  for (const std::string_view compression : kCompressions) {
    const Bytes whole = MakeMcap(folder_, compression);
    const Content all = ReadMcap(folder_ / "made");
    // Messages of the chunks that end up to a byte.
    std::vector<std::pair<size_t, size_t>> chunk_ends;  // byte, messages
    const auto borders = Borders(whole);
    size_t data_end = 0;
    for (size_t i = 0; i < borders.size(); ++i) {
      if (borders[i].first == McapOpcode::kDataEnd) data_end = borders[i + 1].second;
      if (borders[i].first == McapOpcode::kChunk) {
        WriteBytes(folder_ / "torn",
                   Bytes(whole.begin(),
                         whole.begin() + static_cast<std::ptrdiff_t>(borders[i + 1].second)));
        chunk_ends.emplace_back(borders[i + 1].second, ReadMcap(folder_ / "torn").messages.size());
      }
    }
    ASSERT_EQ(chunk_ends.back().second, 120U);
    ASSERT_TRUE(std::ranges::is_sorted(chunk_ends));
    std::vector<size_t> places;
    for (const auto& [end, count] : chunk_ends)
      places.insert(places.end(), {end - 1, end, end + 1});
    const size_t others = compression == "zstd" ? 1000 : 50;
    for (size_t i = 0; i < others; ++i) {
      places.push_back(kMcapMagic.size() + i * (whole.size() - kMcapMagic.size()) / others);
    }
    for (const size_t place : places) {
      WriteBytes(folder_ / "torn",
                 Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(place)));
      const Content torn = ReadMcap(folder_ / "torn");
      size_t expected = 0;
      for (const auto& [end, count] : chunk_ends) expected = end <= place ? count : expected;
      ASSERT_EQ(torn.messages.size(), expected) << place;
      ASSERT_TRUE(std::equal(torn.messages.begin(), torn.messages.end(), all.messages.begin()));
      ASSERT_EQ(torn.trouble.size(), place >= data_end ? 0U : 1U) << place;
    }
  }
}

TEST_F(McapTest, GoesOnBehindAChunkThatIsDamaged) {
  for (const std::string_view compression : kCompressions) {
    Bytes file = MakeMcap(folder_, compression);
    const auto borders = Borders(file);
    const auto chunk =
        std::ranges::find(borders, McapOpcode::kChunk, &std::pair<McapOpcode, size_t>::first);
    const auto next = std::next(chunk);
    file[next->second - 20] ^= 0x40;
    WriteBytes(folder_ / "damaged", file);
    // The first chunk has the channels, but so has the summary.
    const Content content = ReadMcap(folder_ / "damaged");
    EXPECT_GT(content.messages.size(), 80U);
    EXPECT_EQ(content.trouble.size(), 1U);
    // Torn off in front of it, nothing is known of the rest.
    file.resize(
        std::ranges::find(borders, McapOpcode::kDataEnd, &std::pair<McapOpcode, size_t>::first)
            ->second);
    WriteBytes(folder_ / "damaged", file);
    const Content torn = ReadMcap(folder_ / "damaged");
    EXPECT_THAT(torn.messages, IsEmpty());
    EXPECT_THAT(torn.trouble, testing::Contains(HasSubstr("chunk")));
    // Whoever misses a topic asks before any message is read.
    EXPECT_THAT(McapReader({folder_ / "damaged"}).trouble(), testing::Contains(HasSubstr("chunk")));
  }
  Bytes file = MakeMcap(folder_);
  const auto borders = Borders(file);
  std::vector<size_t> chunks;
  for (const auto& [opcode, at] : borders) {
    if (opcode == McapOpcode::kChunk) chunks.push_back(at);
  }
  file[chunks[3] + kRecordHead + 24] ^= 1;  // its CRC
  WriteBytes(folder_ / "damaged", file);
  const Content content = ReadMcap(folder_ / "damaged");
  EXPECT_GT(content.messages.size(), 80U);
  EXPECT_LT(content.messages.size(), 120U);
  EXPECT_THAT(content.trouble,
              ElementsAre("byte " + std::to_string(chunks[3]) + ": chunk: its CRC is another"));
}

TEST_F(McapTest, TakesNoMemoryForAChunkThatCannotBe) {
  Bytes packed(100);
  EXPECT_THAT(UnpackChunk("zstd", packed, kMaxMcapChunkBytes + 1).error().text,
              HasSubstr("allowed are up to 1073741824"));
  EXPECT_THAT(UnpackChunk("lz4", packed, kMaxMcapChunkBytes).error().text, HasSubstr("unpacked"));
  EXPECT_THAT(UnpackChunk("brotli", packed, 1).error().text,
              HasSubstr("'brotli': allowed are zstd, lz4 and none"));
}

// Of the process so far, bytes.
int64_t PeakMemory() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return int64_t{usage.ru_maxrss} << 10;
}

// Behind the first record of the file one more, all of zeros; they take no room on the disk.
void InsertRecord(const std::filesystem::path& path, const Bytes& file, uint8_t opcode,
                  uint64_t size) {
  const auto begin = static_cast<std::ptrdiff_t>(Borders(file)[1].second);
  std::ofstream out(path, std::ios::binary);
  out.write(reinterpret_cast<const char*>(file.data()), begin);
  out.put(static_cast<char>(opcode));
  out.write(reinterpret_cast<const char*>(&size), sizeof size);
  out.seekp(static_cast<std::streamoff>(size), std::ios::cur);
  out.write(reinterpret_cast<const char*>(file.data()) + begin, std::ssize(file) - begin);
  ASSERT_TRUE(out.flush());
}

TEST_F(McapTest, SkipsAttachmentsAndWhatItDoesNotKnowByTheirLength) {
  constexpr uint64_t kBytes = uint64_t{3} << 30;
  constexpr int64_t kLittle = int64_t{100} << 20;
  const Bytes file = MakeMcap(folder_);
  const int64_t before = PeakMemory();
  for (const int opcode : {0x00, 0x08, 0x09, 0x0A, 0x0D, 0x10, 0x80, 0xFF}) {
    InsertRecord(folder_ / "long", file, static_cast<uint8_t>(opcode), kBytes);
    const Content content = ReadMcap(folder_ / "long");
    EXPECT_EQ(content.messages.size(), 120U) << opcode;
    EXPECT_THAT(content.trouble, IsEmpty()) << opcode;
  }
  // Messages of this size are none.
  InsertRecord(folder_ / "long", file, 0x05, kBytes);
  const Content content = ReadMcap(folder_ / "long");
  EXPECT_EQ(content.messages.size(), 120U);
  EXPECT_THAT(content.trouble, ElementsAre(HasSubstr("a record of 3221225472 bytes: allowed")));
  EXPECT_LT(PeakMemory() - before, kLittle);
}

TEST_F(McapTest, EndsWhereNothingWasWritten) {
  Bytes bytes = MakeMcap(folder_, "");
  const size_t whole = bytes.size();
  bytes.resize(whole / 2);
  WriteBytes(folder_ / "torn", bytes);
  const Content torn = ReadMcap(folder_ / "torn");
  ASSERT_THAT(torn.messages, testing::Not(IsEmpty()));
  // The end of a record that was cut is zeros now, and then come records of nothing.
  bytes.resize(whole + 1'000'000);
  WriteBytes(folder_ / "zeros", bytes);
  const Content zeros = ReadMcap(folder_ / "zeros");
  EXPECT_GE(zeros.messages.size(), torn.messages.size());
  EXPECT_THAT(zeros.trouble, testing::Contains(HasSubstr("no record, 1")));
}

TEST_F(McapTest, IsRefusedWhenItIsNone) {
  EXPECT_THROW(McapReader(folder_ / "nothing"), ConfigError);
  std::vector<Event> events = SampleEvents(3);
  WriteBytes(folder_ / "log", MakeLog(events));
  EXPECT_THROW(McapReader(folder_ / "log"), ConfigError);
}

}  // namespace
}  // namespace sprout
