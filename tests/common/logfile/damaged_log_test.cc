#include <gmock/gmock.h>

#include "common/logfile/log_reader.h"
#include "tests/common/logfile/sample_log.h"

// Each test damages a log in one way and says which events must survive.
namespace sprout {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

std::vector<Event> Without(std::vector<Event> events, std::initializer_list<int64_t> numbers) {
  std::erase_if(events, [&](const Event& event) {
    return std::find(numbers.begin(), numbers.end(), event.number) != numbers.end();
  });
  return events;
}

LogDamage Lost(const Event& event) {
  return {.offset = event.offset, .bytes = event.end() - event.offset, .tail = false, .events = 1};
}

class DamagedLog : public testing::Test {
 protected:
  DamagedLog() : events_(SampleEvents(12)), bytes_(MakeLog(events_)) {}

  uint8_t& At(int number, int byte) {
    return bytes_[static_cast<size_t>(events_[static_cast<size_t>(number)].offset + byte)];
  }
  void SetDataLength(int number, int64_t length) {
    for (int i = 0; i < 4; ++i) At(number, 24 + i) = static_cast<uint8_t>(length >> (24 - 8 * i));
  }
  const Event& event(int number) const { return events_[static_cast<size_t>(number)]; }

  std::vector<Event> events_;
  Bytes bytes_;
};

TEST_F(DamagedLog, DropsAnEventWithABadSyncWordAndNotTheOneBefore) {
  At(5, 1) ^= 0x10;
  const LogContent content = ReadLog(bytes_);
  EXPECT_EQ(content.events, Without(events_, {5}));
  EXPECT_THAT(content.damage, ElementsAre(Lost(event(5))));
}

TEST_F(DamagedLog, DropsTheFirstAndTheLastEventAsAnyOther) {
  At(0, 0) ^= 1;
  At(11, 2) ^= 1;
  const LogContent content = ReadLog(bytes_);
  EXPECT_EQ(content.events, Without(events_, {0, 11}));
  ASSERT_EQ(content.damage.size(), 2U);
  EXPECT_EQ(content.damage[0], Lost(event(0)));
  EXPECT_EQ(content.damage[1].offset, event(11).offset);
}

TEST_F(DamagedLog, DoesNotLetAWrongLengthSwallowWhatFollows) {
  for (const int64_t length :
       {int64_t{0}, int64_t{1}, int64_t{200}, int64_t{1000}, int64_t{1} << 30, int64_t{0x7fffffff},
        int64_t{0x80000000}, int64_t{0xffffffff}}) {
    SetDataLength(4, length);
    const LogContent content = ReadLog(bytes_);
    EXPECT_EQ(content.events, Without(events_, {4})) << length;
    EXPECT_THAT(content.damage, ElementsAre(Lost(event(4)))) << length;
  }
}

TEST_F(DamagedLog, DoesNotLetALengthThatEndsAtAnotherEventSwallowTheOnesBetween) {
  SetDataLength(4, static_cast<int64_t>(event(4).data.size()) + event(7).offset - event(5).offset);
  const LogContent content = ReadLog(bytes_);
  EXPECT_EQ(content.events, Without(events_, {4}));
  EXPECT_THAT(content.damage, ElementsAre(Lost(event(4))));
}

TEST_F(DamagedLog, DoesNotLetALengthThatEndsWithTheFileSwallowTheRest) {
  SetDataLength(9, static_cast<int64_t>(event(9).data.size()) + event(11).end() - event(10).offset);
  EXPECT_EQ(ReadLog(bytes_).events, Without(events_, {9}));
}

TEST_F(DamagedLog, DropsAnEventWithABadChannelLength) {
  for (const int length : {0, 1, 6, 20, 63, 64, 255}) {
    At(6, 23) = static_cast<uint8_t>(length);
    EXPECT_EQ(ReadLog(bytes_).events, Without(events_, {6})) << length;
  }
}

TEST_F(DamagedLog, DropsAnEventWithAControlCharacterInItsChannel) {
  At(6, 30) = 0x07;
  EXPECT_EQ(ReadLog(bytes_).events, Without(events_, {6}));
}

TEST_F(DamagedLog, FindsTheGoodEventBetweenTwoDamagedOnes) {
  SetDataLength(4, 999);
  std::fill_n(&At(6, 0), 28, uint8_t{0});  // nothing left of its header
  const LogContent content = ReadLog(bytes_);
  EXPECT_EQ(content.events, Without(events_, {4, 6}));
  EXPECT_THAT(content.damage, ElementsAre(Lost(event(4)), Lost(event(6))));
}

TEST_F(DamagedLog, CountsTheEventsOfAStretchThatWasOverwritten) {
  std::fill(bytes_.begin() + event(3).offset, bytes_.begin() + event(8).offset + 5, uint8_t{0});
  const LogContent content = ReadLog(bytes_);
  EXPECT_EQ(content.events, Without(events_, {3, 4, 5, 6, 7, 8}));
  ASSERT_EQ(content.damage.size(), 1U);
  EXPECT_EQ(content.damage[0].events, 6);
}

TEST_F(DamagedLog, KeepsTheLastEventBeforeATailOfZeros) {
  bytes_.resize(bytes_.size() + 4096);
  const LogContent content = ReadLog(bytes_);
  EXPECT_EQ(content.events, events_);
  EXPECT_THAT(content.damage,
              ElementsAre(LogDamage{event(11).end(), 4096, /*tail=*/false, std::nullopt}));
}

TEST_F(DamagedLog, KeepsAnEventWhoseNumberIsWrong) {
  At(4, 5) ^= 0xff;
  const LogContent content = ReadLog(bytes_);
  EXPECT_EQ(content.events.size(), events_.size());
  EXPECT_THAT(content.damage, IsEmpty());
}

TEST_F(DamagedLog, DoesNotTakeALogInAPayloadForEvents) {
  // 4 events: with more, the numbers inside would go on from those outside.
  std::vector<Event> inner = SampleEvents(4);
  events_[5].data = MakeLog(inner);
  bytes_ = MakeLog(events_);
  EXPECT_EQ(ReadLog(bytes_).events, events_);
  const Bytes good = bytes_;
  At(5, 0) ^= 1;  // around the inner log
  EXPECT_EQ(ReadLog(bytes_).events, Without(events_, {5}));
  bytes_ = good;
  SetDataLength(5, 1 << 20);
  EXPECT_EQ(ReadLog(bytes_).events, Without(events_, {5}));
  bytes_ = good;
  At(6, 0) ^= 1;  // behind it
  EXPECT_EQ(ReadLog(bytes_).events, Without(events_, {6}));
}

TEST_F(DamagedLog, SkipsALogInAPayloadWithTheEventAroundIt) {
  std::vector<Event> inner = SampleEvents(30);  // with numbers that go on from those outside
  events_[5].data = MakeLog(inner);
  bytes_ = MakeLog(events_);
  At(5, 0) ^= 1;
  EXPECT_EQ(ReadLog(bytes_).events, Without(events_, {5}));
}

TEST_F(DamagedLog, KeepsALogInTheLastPayload) {
  std::vector<Event> inner = SampleEvents(30);
  events_.back().data = MakeLog(inner);
  bytes_ = MakeLog(events_);
  EXPECT_EQ(ReadLog(bytes_).events, events_);
}

TEST_F(DamagedLog, IsNotMisledByAWrongNumberBeforeOtherDamage) {
  At(4, 11) ^= 0x07;
  SetDataLength(5, 999);
  const LogContent content = ReadLog(bytes_);
  events_[4].number ^= 0x07;
  EXPECT_EQ(content.events, Without(events_, {5}));
}

TEST(TornLog, KeepsAllWholeEventsWhereverTheLastTwoAreCut) {
  std::vector<Event> events = SampleEvents(14);
  const Bytes bytes = MakeLog(events);
  for (auto size = static_cast<size_t>(events[12].offset); size < bytes.size(); ++size) {
    const LogContent content =
        ReadLog(Bytes(bytes.begin(), bytes.begin() + static_cast<long>(size)));
    const size_t whole = static_cast<int64_t>(size) < events[12].end() ? 12 : 13;
    ASSERT_EQ(content.events,
              std::vector(events.begin(), events.begin() + static_cast<long>(whole)))
        << size;
    const int64_t torn = static_cast<int64_t>(size) - events[whole].offset;
    if (torn == 0) {
      ASSERT_THAT(content.damage, IsEmpty()) << size;
    } else {
      ASSERT_THAT(content.damage,
                  ElementsAre(LogDamage{events[whole].offset, torn, /*tail=*/true, std::nullopt}))
          << size;
    }
  }
}

TEST(TornLog, ReportsALogThatIsCutInItsFirstEvent) {
  std::vector<Event> events = SampleEvents(2);
  Bytes bytes = MakeLog(events);
  bytes.resize(20);
  const LogContent content = ReadLog(bytes);
  EXPECT_THAT(content.events, IsEmpty());
  EXPECT_THAT(content.damage, ElementsAre(LogDamage{0, 20, /*tail=*/true, std::nullopt}));
}

}  // namespace
}  // namespace sprout
