#include "common/bus/datagram_joiner.h"

#include <gtest/gtest.h>

#include <random>

namespace sprout {
namespace {

using Datagram = std::vector<uint8_t>;

constexpr DatagramJoiner::Sender kSender{1, 2};
const DatagramJoiner::Time kNow{};

void Append(Datagram& datagram, uint32_t value, int bytes) {
  for (int shift = 8 * (bytes - 1); shift >= 0; shift -= 8) {
    datagram.push_back(static_cast<uint8_t>(value >> shift));
  }
}

void Append(Datagram& datagram, const std::string& text) {
  datagram.insert(datagram.end(), text.begin(), text.end());
}

Datagram Short(uint32_t number, const std::string& channel, const std::string& data) {
  Datagram datagram;
  Append(datagram, 0x4c433032, 4);
  Append(datagram, number, 4);
  Append(datagram, channel + '\0' + data);
  return datagram;
}

struct Place {
  uint32_t message_bytes;
  uint32_t offset;
  uint32_t index;
  uint32_t count;
};

Datagram Long(uint32_t number, const Place& place, const std::string& rest) {
  Datagram datagram;
  Append(datagram, 0x4c433033, 4);
  Append(datagram, number, 4);
  Append(datagram, place.message_bytes, 4);
  Append(datagram, place.offset, 4);
  Append(datagram, place.index, 2);
  Append(datagram, place.count, 2);
  Append(datagram, rest);
  return datagram;
}

// "abcdefghij" on channel C, in three.
std::vector<Datagram> Three(uint32_t number, const std::string& channel = "C") {
  return {Long(number, {10, 0, 0, 3}, channel + '\0' + "abcd"), Long(number, {10, 4, 1, 3}, "efg"),
          Long(number, {10, 7, 2, 3}, "hij")};
}

class DatagramJoinerTest : public ::testing::Test {
 protected:
  // "channel data" of what is whole with this datagram; empty when nothing is.
  std::string Add(const Datagram& datagram, const DatagramJoiner::Sender& sender = kSender,
                  DatagramJoiner::Time now = kNow) {
    const auto message = joiner_.Add(sender, datagram, now);
    if (!message) return "";
    const std::span<const uint8_t> bytes = message->bytes;
    return message->channel + " " + std::string(bytes.begin(), bytes.end());
  }

  DatagramJoiner joiner_{[](std::string_view channel) -> size_t {
    return channel == "UNWANTED" ? 0 : channel == "HEAD" ? 5 : 1000;
  }};
};

TEST_F(DatagramJoinerTest, JoinsDatagramsInAnyOrder) {
  std::vector<int> order = {0, 1, 2};
  uint32_t number = 0;
  do {
    const std::vector<Datagram> datagrams = Three(++number);
    EXPECT_EQ(Add(datagrams[static_cast<size_t>(order[0])]), "");
    EXPECT_EQ(Add(datagrams[static_cast<size_t>(order[1])]), "");
    EXPECT_EQ(Add(datagrams[static_cast<size_t>(order[2])]), "C abcdefghij");
  } while (std::next_permutation(order.begin(), order.end()));
}

TEST_F(DatagramJoinerTest, WaitsForEveryDatagramWhenSomeComeTwice) {
  const std::vector<Datagram> datagrams = Three(1);
  EXPECT_EQ(Add(datagrams[0]), "");
  EXPECT_EQ(Add(datagrams[0]), "");
  EXPECT_EQ(Add(datagrams[1]), "");
  EXPECT_EQ(Add(datagrams[1]), "");
  EXPECT_EQ(Add(datagrams[2]), "C abcdefghij");
  for (const Datagram& datagram : datagrams) EXPECT_EQ(Add(datagram), "");
}

TEST_F(DatagramJoinerTest, GivesAMessageOnceHoweverOftenItComes) {
  EXPECT_EQ(Add(Short(1, "C", "abc")), "C abc");
  EXPECT_EQ(Add(Short(1, "C", "abc")), "");
  // A sender that was started again on the same port begins with the same numbers.
  EXPECT_EQ(Add(Short(1, "C", "abc"), kSender, kNow + std::chrono::milliseconds(1100)), "C abc");
  EXPECT_EQ(Add(Short(2, "C", "")), "C ");
}

TEST_F(DatagramJoinerTest, TellsSendersApart) {
  const std::vector<Datagram> datagrams = Three(1);
  for (const DatagramJoiner::Sender& sender : {DatagramJoiner::Sender{1, 2}, {1, 3}, {2, 2}}) {
    EXPECT_EQ(Add(datagrams[0], sender), "");
    EXPECT_EQ(Add(datagrams[1], sender), "");
  }
  for (const DatagramJoiner::Sender& sender : {DatagramJoiner::Sender{1, 2}, {1, 3}, {2, 2}}) {
    EXPECT_EQ(Add(datagrams[2], sender), "C abcdefghij");
  }
}

TEST_F(DatagramJoinerTest, PassesOverWhatIsNotWanted) {
  EXPECT_EQ(Add(Short(1, "UNWANTED", "abc")), "");
  for (const Datagram& datagram : Three(2, "UNWANTED")) EXPECT_EQ(Add(datagram), "");
}

TEST_F(DatagramJoinerTest, GivesTheBeginningAloneWhereNoMoreIsWanted) {
  EXPECT_EQ(Add(Short(1, "HEAD", "abcdefghij")), "HEAD abcde");
  EXPECT_EQ(Add(Short(2, "HEAD", "abc")), "HEAD abc");
  std::vector<Datagram> datagrams = Three(3, "HEAD");
  EXPECT_EQ(Add(datagrams[0]), "");
  EXPECT_EQ(Add(datagrams[1]), "");
  EXPECT_EQ(Add(datagrams[2]), "HEAD abcde");  // when all of it has come
  datagrams = Three(4, "HEAD");
  EXPECT_EQ(Add(datagrams[2]), "");
  EXPECT_EQ(Add(datagrams[1]), "");
  EXPECT_EQ(Add(datagrams[0]), "HEAD abcde");
}

TEST_F(DatagramJoinerTest, RefusesDatagramsThatCannotBe) {
  EXPECT_EQ(Add({}), "");
  EXPECT_EQ(Add(Datagram(7)), "");
  EXPECT_EQ(Add(Datagram(100)), "");
  EXPECT_EQ(Add(Short(1, std::string(64, 'C'), "abc")), "");
  Datagram endless = Short(1, "C", "");
  endless.pop_back();
  EXPECT_EQ(Add(endless), "");
  constexpr uint32_t kHuge = 0xffffffff;
  const std::string channel = std::string("C") + '\0';
  for (const Place& place : {Place{kHuge, 0, 0, 1},
                             {3, kHuge, 0, 1},
                             {3, 0, 1, 1},
                             {3, 0, 0, 0},
                             {2, 0, 0, 1},
                             {3, 1, 0, 1},
                             {0, 0, 0, 1},
                             {4, 0, 0, 1}}) {
    EXPECT_EQ(Add(Long(2, place, channel + "abc")), "") << place.message_bytes;
  }
  EXPECT_EQ(Add(Long(3, {3, 0, 0, 1}, channel + "abc")), "C abc");
}

TEST_F(DatagramJoinerTest, GivesNothingOfDatagramsThatOverlap) {
  const std::string channel = std::string("C") + '\0';
  EXPECT_EQ(Add(Long(1, {10, 0, 0, 2}, channel + "abcd")), "");
  EXPECT_EQ(Add(Long(1, {10, 0, 1, 2}, "abcd")), "");
}

TEST_F(DatagramJoinerTest, IgnoresWhatContradictsTheFirstDatagram) {
  EXPECT_EQ(Add(Three(1)[0]), "");
  EXPECT_EQ(Add(Long(1, {11, 4, 1, 3}, "efg")), "");
  EXPECT_EQ(Add(Long(1, {10, 4, 1, 4}, "efg")), "");
  EXPECT_EQ(Add(Three(1)[1]), "");
  EXPECT_EQ(Add(Three(1)[2]), "C abcdefghij");
}

TEST_F(DatagramJoinerTest, DropsTheOldestOfTooManyUnfinishedOnes) {
  for (uint32_t i = 0; i <= DatagramJoiner::kMaxPending; ++i) EXPECT_EQ(Add(Three(i)[0]), "");
  for (const uint32_t number : {uint32_t{0}, uint32_t{DatagramJoiner::kMaxPending}}) {
    Add(Three(number)[1]);
    EXPECT_EQ(Add(Three(number)[2]), number == 0 ? "" : "C abcdefghij");
  }
}

TEST_F(DatagramJoinerTest, SurvivesRandomDatagrams) {
  std::mt19937 random(1);
  for (int i = 0; i < 100'000; ++i) {
    const auto number = [&](uint32_t below) { return static_cast<uint32_t>(random() % below); };
    Datagram datagram = Long(
        number(20),
        {number(2) == 0 ? 10 : static_cast<uint32_t>(random()), number(12), number(4), number(4)},
        std::string(number(12), 'x'));
    datagram.resize(number(static_cast<uint32_t>(datagram.size()) + 1));
    Add(datagram);
  }
  EXPECT_EQ(Add(Short(99, "C", "abc")), "C abc");
}

}  // namespace
}  // namespace sprout
