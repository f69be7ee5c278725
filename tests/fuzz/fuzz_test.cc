// Every target on its good inputs, on what fuzzing found once (findings/TARGET), and on nothing.
#include <gtest/gtest.h>

#include <filesystem>
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
