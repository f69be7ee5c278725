#include <gmock/gmock.h>

#include <algorithm>
#include <random>

#include "common/logfile/log_reader.h"
#include "tests/common/logfile/sample_log.h"

namespace sprout {
namespace {

// Where a changed byte can show: sync word and lengths. Numbers, times, channels and payloads may
// change into others that are as good.
bool MustShow(int64_t byte_of_event) {
  return byte_of_event < 4 || (byte_of_event >= 20 && byte_of_event < 28);
}

class Damager {
 public:
  Damager(std::vector<Event> events, Bytes bytes)
      : events_(std::move(events)), bytes_(std::move(bytes)), hurt_(events_.size()) {}

  void Flip(std::mt19937& random) {
    const auto at = std::uniform_int_distribution<size_t>(0, bytes_.size() - 1)(random);
    const auto mask = std::uniform_int_distribution<int>(1, 255)(random);
    bytes_[at] = static_cast<uint8_t>(bytes_[at] ^ mask);
    const auto next = std::find_if(events_.begin(), events_.end(), [&](const Event& event) {
      return event.end() > static_cast<int64_t>(at);
    });
    hurt_[static_cast<size_t>(next - events_.begin())] = true;
    shows_ = shows_ || MustShow(static_cast<int64_t>(at) - next->offset);
  }

  const Bytes& bytes() const { return bytes_; }
  bool shows() const { return shows_; }

  std::vector<Event> Unhurt() const {
    std::vector<Event> unhurt;
    for (size_t i = 0; i < events_.size(); ++i) {
      if (!hurt_[i]) unhurt.push_back(events_[i]);
    }
    return unhurt;
  }

 private:
  std::vector<Event> events_;
  Bytes bytes_;
  std::vector<bool> hurt_;
  bool shows_ = false;
};

// All of `events` are among those read, and all bytes are either events or reported as damage.
void ExpectRecovered(const LogContent& content, const std::vector<Event>& events, int64_t size,
                     const std::string& where) {
  for (const Event& event : events) {
    ASSERT_NE(std::find(content.events.begin(), content.events.end(), event), content.events.end())
        << where << ": lost event " << event.number;
  }
  int64_t bytes = 0;
  for (const Event& event : content.events) bytes += event.end() - event.offset;
  for (const LogDamage& damage : content.damage) bytes += damage.bytes;
  ASSERT_EQ(bytes, size) << where;
}

TEST(RandomDamage, OneByteCostsAtMostItsOwnEvent) {
  std::vector<Event> events = SampleEvents(14);
  const Bytes bytes = MakeLog(events);
  for (unsigned seed = 0; seed < 1000; ++seed) {
    std::mt19937 random(seed);
    Damager damager(events, bytes);
    damager.Flip(random);
    const LogContent content = ReadLog(damager.bytes());
    const std::string where = "seed " + std::to_string(seed);
    ExpectRecovered(content, damager.Unhurt(), static_cast<int64_t>(bytes.size()), where);
    ASSERT_GE(content.events.size(), events.size() - 1) << where;
    ASSERT_LE(content.events.size(), events.size()) << where;
    ASSERT_TRUE(content.damage.size() == 1 || !damager.shows()) << where;
  }
}

TEST(RandomDamage, AThousandBytesCostAtMostTheirOwnEvents) {
  std::vector<Event> events = SampleEvents(4000);
  const Bytes bytes = MakeLog(events);
  for (unsigned seed = 0; seed < 50; ++seed) {
    std::mt19937 random(seed);
    Damager damager(events, bytes);
    for (int i = 0; i < 1000; ++i) damager.Flip(random);
    ExpectRecovered(ReadLog(damager.bytes()), damager.Unhurt(), static_cast<int64_t>(bytes.size()),
                    "seed " + std::to_string(seed));
  }
}

}  // namespace
}  // namespace sprout
