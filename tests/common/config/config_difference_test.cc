#include "common/config/config_difference.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/config/config.h"

namespace sprout {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

TEST(ConfigDifferences, AreNoneBetweenEqualConfigurations) {
  const std::string text = ConfigText(LoadConfig({"default"}));
  EXPECT_THAT(ConfigDifferences(text, text), IsEmpty());
}

TEST(ConfigDifferences, NameKeysAndValues) {
  SproutConfig config = LoadConfig({"default"});
  const std::string before = ConfigText(config);
  config.mutable_grow()->set_sigma_p_px(2);
  config.mutable_capture()->set_source("log:run: 7 {.lcm");
  const auto differences = ConfigDifferences(before, ConfigText(config));
  ASSERT_EQ(differences.size(), 2U);
  EXPECT_EQ(differences[0].key, "capture.source");
  EXPECT_EQ(differences[0].b, "\"log:run: 7 {.lcm\"");
  EXPECT_EQ(differences[1], (ConfigDifference{"grow.sigma_p_px", "0.8", "2"}));
}

TEST(ConfigDifferences, CompareWhatOtherVersionsPrinted) {
  EXPECT_THAT(ConfigDifferences("grow {\n  old: 1\n  mode: GONE\n}\n",
                                "grow {\n  mode: NEW\n  part {\n    new: 2\n  }\n}\ntop: 3\n"),
              ElementsAre(ConfigDifference{"grow.mode", "GONE", "NEW"},
                          ConfigDifference{"grow.old", "1", "none"},
                          ConfigDifference{"grow.part.new", "none", "2"},
                          ConfigDifference{"top", "none", "3"}));
}

TEST(ConfigDifferences, SurviveAnyText) {
  EXPECT_THAT(ConfigDifferences("}\n}\n{ {\n: \n  \n", ""), ElementsAre());
  EXPECT_THAT(ConfigDifferences("a: 1", "a: 1\n"), IsEmpty());
}

}  // namespace
}  // namespace sprout
