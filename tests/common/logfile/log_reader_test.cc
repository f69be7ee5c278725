#include "common/logfile/log_reader.h"

#include <gmock/gmock.h>
#include <lcm/lcm.h>
#include <sys/stat.h>

#include "tests/common/logfile/sample_log.h"
#include "tests/common/testing/test_with_folder.h"
#include "tests/common/testing/thrown.h"

namespace sprout {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

class LogReaderTest : public TestWithFolder {};

TEST_F(LogReaderTest, ReadsWhatLogWriterWrites) {
  std::vector<Event> events = SampleEvents(50);
  const LogContent content = ReadLog(MakeLog(events));
  EXPECT_EQ(content.events, events);
  EXPECT_THAT(content.damage, IsEmpty());
}

TEST_F(LogReaderTest, ReadsWhatLcmWrites) {
  std::vector<Event> events = SampleEvents(20);
  lcm_eventlog_t* const log = lcm_eventlog_create((folder_ / "log").c_str(), "w");
  for (Event& event : events) {
    lcm_eventlog_event_t written = {.eventnum = 0,
                                    .timestamp = event.utime,
                                    .channellen = static_cast<int32_t>(event.channel.size()),
                                    .datalen = static_cast<int32_t>(event.data.size()),
                                    .channel = event.channel.data(),
                                    .data = event.data.data()};
    ASSERT_EQ(lcm_eventlog_write_event(log, &written), 0);
  }
  lcm_eventlog_destroy(log);
  MakeLog(events);  // numbers and offsets
  EXPECT_EQ(ReadLog(folder_ / "log").events, events);
}

TEST_F(LogReaderTest, ReadsEventsLongerThanItsWindow) {
  std::vector<Event> events = SampleEvents(6);
  events[1].data.assign(5 << 20, 17);
  events[3].data.assign((1 << 20) - 28, 18);
  EXPECT_EQ(ReadLog(MakeLog(events)).events, events);
}

TEST(EventFetcher, GetsEventsAgainInAnyOrder) {
  const TemporaryDirectory folder;
  std::vector<Event> events = SampleEvents(12);
  events[4].data.assign(1 << 20, 17);
  WriteBytes(folder / "log", MakeLog(events));
  EventFetcher fetcher(folder / "log");
  for (const size_t i : {11U, 4U, 5U, 0U, 4U}) {
    const LogEvent event = fetcher.Fetch(events[i].offset);
    EXPECT_EQ(event.number, events[i].number);
    EXPECT_EQ(event.channel, events[i].channel);
    EXPECT_TRUE(std::equal(event.data.begin(), event.data.end(), events[i].data.begin(),
                           events[i].data.end()));
  }
  EXPECT_THROW(fetcher.Fetch(events[11].end()), LogError);
}

TEST_F(LogReaderTest, TellsHowFarItIs) {
  std::vector<Event> events = SampleEvents(3);
  const Bytes bytes = MakeLog(events);
  WriteBytes(folder_ / "log", bytes);
  LogReader reader(folder_ / "log");
  EXPECT_EQ(reader.size(), static_cast<int64_t>(bytes.size()));
  EXPECT_EQ(reader.position(), 0);
  LogEvent event;
  ASSERT_TRUE(reader.Next(event));
  EXPECT_EQ(reader.position(), events[1].offset);
}

TEST_F(LogReaderTest, TakesAFileWithoutBytesForALogWithoutEvents) {
  const LogContent content = ReadLog(Bytes());
  EXPECT_THAT(content.events, IsEmpty());
  EXPECT_THAT(content.damage, IsEmpty());
}

TEST_F(LogReaderTest, ReadsLogsOneBehindTheOther) {
  std::vector<Event> events = SampleEvents(20);
  Bytes bytes = MakeLog(events);
  const Bytes once = bytes;
  bytes.insert(bytes.end(), once.begin(), once.end());
  const LogContent content = ReadLog(bytes);
  EXPECT_EQ(content.events.size(), 40U);
  EXPECT_THAT(content.damage, IsEmpty());
}

std::string ErrorOfOpening(const std::filesystem::path& path) {
  return Thrown<LogError>([&] { const LogReader reader(path); });
}

TEST_F(LogReaderTest, RefusesWhatIsNoLog) {
  std::ofstream(folder_ / "text") << std::string(100'000, 'x');
  EXPECT_EQ(ErrorOfOpening(folder_ / "text"), (folder_ / "text").string() + ": not an LCM log");
  const auto error_of = [&](const char* begin) {
    std::ofstream(folder_ / "other") << begin << std::string(100, 'x');
    return ErrorOfOpening(folder_ / "other");
  };
  EXPECT_THAT(error_of("\x1f\x8b"), HasSubstr("not an LCM log: packed with gzip; unpack it with"));
  EXPECT_THAT(error_of("\x28\xb5\x2f\xfd"), HasSubstr("packed with zstd; unpack it with unzstd"));
  EXPECT_THAT(error_of("\x89MCAP0\r\n"), HasSubstr("a bag of ROS 2; sprout-capture --source"));
  EXPECT_THAT(ErrorOfOpening(folder_ / ""), HasSubstr("not a file"));
  EXPECT_THAT(ErrorOfOpening("/dev/zero"), HasSubstr("not a file"));
  ASSERT_EQ(mkfifo((folder_ / "fifo").c_str(), 0600), 0);
  EXPECT_THAT(ErrorOfOpening(folder_ / "fifo"), HasSubstr("not a file"));
  EXPECT_THAT(ErrorOfOpening(folder_ / "none"), HasSubstr("No such file"));
}

TEST_F(LogReaderTest, SaysWhenTheFileBecomesShorter) {
  std::vector<Event> events = SampleEvents(6);
  events[5].data.assign(5 << 20, 17);
  WriteBytes(folder_ / "log", MakeLog(events));
  LogReader reader(folder_ / "log");
  LogEvent event;
  ASSERT_TRUE(reader.Next(event));
  std::filesystem::resize_file(folder_ / "log", static_cast<uintmax_t>(events[5].offset));
  const auto read_on = [&] {
    while (reader.Next(event)) {
    }
  };
  EXPECT_THROW(read_on(), LogError);
}

}  // namespace
}  // namespace sprout
