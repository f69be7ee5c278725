#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "tests/common/messages/examples.h"
#include "tests/common/testing/allocation_guard.h"

// Random damage: whatever comes, an answer and no crash (the asan preset looks closely), and no
// memory out of proportion.
namespace sprout {
namespace {

constexpr int kRounds = 20000;

// The examples have a few hundred bytes. A Zstandard frame of that size may rightly become a map
// of 32768 times as many bytes.
size_t AllowedBytes(const std::string& name, size_t message_bytes) {
  return name.starts_with("zstd") ? 32768 * message_bytes : 4 * message_bytes + 4096;
}

class Fuzz : public ::testing::TestWithParam<size_t> {
 protected:
  const examples::Wire wire_ = examples::AllWires()[GetParam()];
  std::mt19937 random_{static_cast<unsigned>(GetParam())};

  void Decode(const std::vector<uint8_t>& bytes) {
    const AllocationGuard guard;
    wire_.ErrorOf(bytes);
    ASSERT_LE(guard.largest(), AllowedBytes(wire_.name, wire_.bytes.size())) << wire_.name;
  }

  size_t Below(size_t bound) { return random_() % bound; }
};

TEST_P(Fuzz, SurvivesFlippedBytes) {
  for (int round = 0; round < kRounds; ++round) {
    std::vector<uint8_t> bytes = wire_.bytes;
    const size_t flips = 1 + Below(4);
    for (size_t i = 0; i < flips; ++i) {
      // Behind the fingerprint, which would end the test too early.
      bytes[8 + Below(bytes.size() - 8)] = static_cast<uint8_t>(random_());
    }
    Decode(bytes);
    if (HasFatalFailure()) return;
  }
}

TEST_P(Fuzz, SurvivesExtremeNumbersAnywhere) {
  constexpr int32_t kExtreme[] = {0, 1, -1, INT32_MIN, INT32_MAX, 16384, 16385, 1 << 24, 255};
  for (size_t offset = 8; offset + 4 <= wire_.bytes.size(); ++offset) {
    for (const int32_t value : kExtreme) {
      Decode(examples::Patched(wire_.bytes, offset, value));
      if (HasFatalFailure()) return;
    }
  }
}

TEST_P(Fuzz, SurvivesNoise) {
  for (int round = 0; round < 2000; ++round) {
    std::vector<uint8_t> bytes(8 + Below(wire_.bytes.size()));
    for (uint8_t& byte : bytes) byte = static_cast<uint8_t>(random_());
    std::copy_n(wire_.bytes.begin(), 8, bytes.begin());
    Decode(bytes);
    if (HasFatalFailure()) return;
  }
}

std::string NameOf(const ::testing::TestParamInfo<size_t>& index) {
  std::string name = examples::AllWires()[index.param].name;
  std::replace(name.begin(), name.end(), ' ', '_');
  return name;
}

INSTANTIATE_TEST_SUITE_P(AllMessages, Fuzz,
                         ::testing::Range<size_t>(0, examples::AllWires().size()), NameOf);

}  // namespace
}  // namespace sprout
