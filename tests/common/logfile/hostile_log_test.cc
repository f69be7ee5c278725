// Logs that were made to keep the reader busy: nothing but sync words whose headers contradict each
// other, so that each takes a search through all others.
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>

#include "common/logfile/event_format.h"
#include "common/logfile/log_reader.h"
#include "tests/common/logfile/sample_log.h"
#include "tests/common/testing/worst_case.h"

namespace sprout {
namespace {

constexpr int kCount = kWorstCount / 4;
constexpr int64_t kSlot = 32;  // bytes from one header to the next

// Of the header in a slot.
EventHeader Header(int64_t number, int64_t bytes) {
  return {.number = number,
          .utime = 0,
          .channel_bytes = 1,
          .data_bytes = static_cast<int32_t>(bytes - kHeaderBytes - 1)};
}

Bytes MakeSlots(const std::function<EventHeader(int slot)>& header) {
  Bytes bytes(kCount * kSlot, 'x');
  for (int slot = 0; slot < kCount; ++slot) {
    const auto head = EncodeHeader(header(slot));
    std::copy(head.begin(), head.end(), bytes.begin() + slot * kSlot);
  }
  return bytes;
}

// Reads the log, and looks whether all bytes are accounted for.
void ExpectReadInTime(const Bytes& bytes) {
  LogContent content;
  EXPECT_LT(CpuSeconds([&] { content = ReadLog(bytes); }), kWorstSeconds / 3);
  int64_t sum = 0;
  for (const Event& event : content.events) sum += event.end() - event.offset;
  for (const LogDamage& damage : content.damage) sum += damage.bytes;
  EXPECT_EQ(sum, std::ssize(bytes));
}

constexpr int64_t kFar = int64_t{1} << 40;  // a number that is not in sequence

TEST(HostileLog, EventsThatReachToTheEndAndAreContradictedThereAreReadInTime) {
  ExpectReadInTime(MakeSlots([](int slot) {
    constexpr int kLast = kCount - 1;
    if (slot == kLast) return Header(kFar + 5, kSlot);
    if (slot == kLast - 1) return Header(kFar + 1, kSlot);
    return Header(kFar, (kLast - slot) * kSlot);
  }));
}

TEST(HostileLog, EventsOutOfSequenceBetweenDamageAreReadInTime) {
  ExpectReadInTime(MakeSlots([](int slot) {
    EventHeader header = Header(kFar - slot, kSlot);
    if (slot % 2 == 1) header.channel_bytes = 0;
    return header;
  }));
}

TEST(HostileLog, EventsInSequenceThatALaterOneContradictsAreReadInTime) {
  ExpectReadInTime(MakeSlots(
      [](int slot) { return slot == kCount - 1 ? Header(1, kSlot) : Header(0, kSlot - 1); }));
}

// What damage takes is far from the budget: the last event of a hundred megabytes is found.
TEST(HostileLog, SyncWordsInPayloadsDoNotUseUpTheBudget) {
  std::vector<Event> events(60);
  for (Event& event : events) {
    event.channel = "SPROUT_LEFT";
    event.data.resize(size_t{1} << 20);
    for (size_t i = 0; i + 4 <= event.data.size(); i += 4) {
      std::copy(kSyncWord.begin(), kSyncWord.end(), event.data.begin() + static_cast<long>(i));
    }
  }
  Bytes bytes = MakeLog(events);
  const std::vector<Event> all = events;
  for (size_t i = 5; i < events.size(); i += 10) {
    bytes[static_cast<size_t>(events[i].offset)] ^= 1;
  }
  const LogContent content = ReadLog(bytes);
  EXPECT_EQ(content.events.size(), 54U);
  EXPECT_EQ(content.events.back(), all.back());
}

}  // namespace
}  // namespace sprout
