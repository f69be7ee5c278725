// Every target on its good inputs, their beginnings and mutations, and on what fuzzing found once
// (findings/TARGET).
#include <gtest/gtest.h>

#include <filesystem>
#include <random>
#include <system_error>

#include "tests/common/logfile/sample_log.h"
#include "tests/fuzz/target.h"

namespace sprout::fuzz {
namespace {

namespace fs = std::filesystem;

class FuzzTarget : public ::testing::TestWithParam<std::string> {
 protected:
  const Target& target_ = TargetNamed(GetParam());
};

TEST_P(FuzzTarget, TakesItsGoodInputsAndEveryBeginningOfThem) {
  const std::vector<Bytes> seeds = target_.seeds();
  ASSERT_FALSE(seeds.empty());
  for (const Bytes& seed : seeds) {
    EXPECT_LE(seed.size(), target_.longest);
    const size_t step = seed.size() / 64 + 1;
    for (size_t size = 0; size < seed.size(); size += step)
      target_.run(std::span(seed).first(size));
    target_.run(seed);
  }
}

TEST_P(FuzzTarget, SurvivesMutations) {
  std::mt19937 random(1);
  const std::vector<Bytes> seeds = target_.seeds();
  for (size_t i = 0; i < 5000; ++i) {
    Bytes bytes = seeds[i % seeds.size()];
    if (bytes.empty()) continue;
    for (uint32_t k = random() % 4 + 1; k > 0; --k) {
      bytes[random() % bytes.size()] = static_cast<uint8_t>(random() % 3 == 0 ? 0xff : random());
    }
    if (random() % 4 == 0) bytes.resize(random() % bytes.size());
    target_.run(bytes);
  }
}

TEST_P(FuzzTarget, SurvivesWhatWasFoundOnce) {
  const fs::path folder = fs::path(SPROUT_SOURCE_DIR) / "tests/fuzz/findings" / target_.name;
  std::error_code nothing_was_found;
  for (const auto& file : fs::directory_iterator(folder, nothing_was_found)) {
    SCOPED_TRACE(file.path());
    target_.run(ReadBytes(file.path()));
  }
}

std::vector<std::string> Names() {
  std::vector<std::string> names;
  for (const Target& target : Targets()) names.emplace_back(target.name);
  return names;
}

INSTANTIATE_TEST_SUITE_P(Each, FuzzTarget, ::testing::ValuesIn(Names()),
                         [](const auto& name) { return name.param; });

}  // namespace
}  // namespace sprout::fuzz
