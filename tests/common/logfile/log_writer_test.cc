#include "common/logfile/log_writer.h"

#include <gmock/gmock.h>
#include <lcm/lcm.h>

#include "tests/common/logfile/sample_log.h"
#include "tests/common/testing/test_with_folder.h"
#include "tests/common/testing/thrown.h"

namespace sprout {
namespace {

using testing::HasSubstr;

class LogWriterTest : public TestWithFolder {};

TEST_F(LogWriterTest, WritesWhatLcmReads) {
  std::vector<Event> events = SampleEvents(20);
  WriteBytes(folder_ / "log", MakeLog(events));
  lcm_eventlog_t* const log = lcm_eventlog_create((folder_ / "log").c_str(), "r");
  ASSERT_NE(log, nullptr);
  for (const Event& event : events) {
    lcm_eventlog_event_t* const read = lcm_eventlog_read_next_event(log);
    ASSERT_NE(read, nullptr);
    EXPECT_EQ(read->eventnum, event.number);
    EXPECT_EQ(read->timestamp, event.utime);
    EXPECT_EQ(std::string(read->channel), event.channel);
    const auto* data = static_cast<const uint8_t*>(read->data);
    EXPECT_EQ(Bytes(data, data + read->datalen), event.data);
    lcm_eventlog_free_event(read);
  }
  EXPECT_EQ(lcm_eventlog_read_next_event(log), nullptr);
  lcm_eventlog_destroy(log);
}

TEST_F(LogWriterTest, LeavesAnOlderLogToItsReader) {
  std::vector<Event> events = SampleEvents(5);
  const Bytes bytes = MakeLog(events);
  WriteBytes(folder_ / "log", bytes);
  LogReader reader(folder_ / "log");
  LogEvent event;
  ASSERT_TRUE(reader.Next(event));
  LogWriter writer(folder_ / "log");
  EXPECT_EQ(ReadBytes(folder_ / "log"), bytes) << "until it is whole";
  writer.Close();
  EXPECT_EQ(ReadBytes(folder_ / "log"), Bytes());
  int left = 0;
  while (reader.Next(event)) ++left;
  EXPECT_EQ(left, 4);
}

TEST_F(LogWriterTest, LeavesNothingBehindWithoutClose) {
  { LogWriter(folder_ / "log").Write(1, "A", {}); }
  EXPECT_EQ(folder_.CountEntries(), 0);
}

TEST_F(LogWriterTest, OverwritesOnDemandOnly) {
  WriteBytes(folder_ / "log", {1, 2, 3});
  EXPECT_THAT(Thrown<LogError>([&] { LogWriter(folder_ / "log", /*overwrite=*/false); }),
              HasSubstr("exists already; --force"));
  EXPECT_EQ(ReadBytes(folder_ / "log"), (Bytes{1, 2, 3}));
  EXPECT_EQ(folder_.CountEntries(), 1);
  EXPECT_EQ(Thrown<LogError>([&] { LogWriter("/dev/null", /*overwrite=*/false).Close(); }),
            "no error");
}

TEST_F(LogWriterTest, NamesAFileThatCannotBeCreated) {
  const auto path = folder_ / "none" / "log";
  EXPECT_EQ(Thrown<LogError>([&] { LogWriter writer(path); }),
            path.string() + ": cannot be written (No such file or directory)");
}

TEST_F(LogWriterTest, ReportsAFullDiskInClose) {
  LogWriter writer("/dev/full");
  writer.Write(1, "A", Bytes(10));  // stays in the buffer
  EXPECT_THAT(Thrown<LogError>([&] { writer.Close(); }), HasSubstr("No space left"));
}

TEST_F(LogWriterTest, ReportsAFullDiskInWrite) {
  LogWriter writer("/dev/full");
  EXPECT_THAT(Thrown<LogError>([&] { writer.Write(1, "A", Bytes(4 << 20)); }),
              HasSubstr("No space left"));
}

TEST_F(LogWriterTest, RefusesChannelsThatLcmDoesNotKnow) {
  LogWriter writer(folder_ / "log");
  EXPECT_THAT(Thrown<LogError>([&] { writer.Write(1, "", {}); }), HasSubstr("1 to 63"));
  EXPECT_THAT(Thrown<LogError>([&] { writer.Write(1, std::string(64, 'A'), {}); }),
              HasSubstr("1 to 63"));
  writer.Write(1, std::string(63, 'A'), {});
  EXPECT_EQ(writer.events(), 1);
}

}  // namespace
}  // namespace sprout
