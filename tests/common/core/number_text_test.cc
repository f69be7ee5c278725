#include "common/core/number_text.h"

#include <gtest/gtest.h>

#include <cstdint>

namespace sprout {
namespace {

TEST(ParseNumber, TakesAFiniteNumberAndNothingElse) {
  EXPECT_EQ(ParseNumber<int>("12"), 12);
  EXPECT_EQ(ParseNumber<int>("-3"), -3);
  EXPECT_EQ(ParseNumber<int64_t>("9007199254740993"), 9007199254740993);
  EXPECT_EQ(ParseNumber<double>("-2.5e3"), -2500);
  for (const char* text : {"", " 1", "1 ", "+1", "1x", "x", "1,5", "0x10", "nan", "inf", "1e999"}) {
    EXPECT_FALSE(ParseNumber<double>(text)) << text;
  }
  for (const char* text : {"1.5", "2147483648", "1e3", "--1"}) {
    EXPECT_FALSE(ParseNumber<int>(text)) << text;
  }
}

TEST(Trimmed, TakesBlanksAndLineEndsAway) {
  EXPECT_EQ(Trimmed(" \ta b\r\n"), "a b");
  EXPECT_EQ(Trimmed(" \n"), "");
  EXPECT_EQ(Trimmed(""), "");
}

}  // namespace
}  // namespace sprout
