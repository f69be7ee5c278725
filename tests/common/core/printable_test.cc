#include "common/core/printable.h"

#include <gtest/gtest.h>

#include <cstdint>

#include "common/core/number_text.h"

namespace sprout {
namespace {

TEST(Printable, LeavesTextAsItIs) {
  for (const char* text : {"", "/rig/left.png", "größer × 2", "日本", "😀", "a\\x1b"}) {
    EXPECT_EQ(Printable(text), text);
    EXPECT_EQ(PrintableLines(text), text);
  }
}

TEST(Printable, ShowsWhatATerminalWouldObey) {
  EXPECT_EQ(Printable("a\x1b[2J\r\n\t\x7f"), "a\\x1b[2J\\x0d\\x0a\\x09\\x7f");
  EXPECT_EQ(Printable(std::string_view("\0", 1)), "\\x00");
  EXPECT_EQ(Printable("\xc2\x9b"
                      "2J"),
            "\\xc2\\x9b2J");  // CSI of C1
  EXPECT_EQ(PrintableLines("a\n\tb\r\x1b"), "a\n\tb\\x0d\\x1b");
}

TEST(Printable, ShowsBytesThatAreNoUtf8) {
  // A byte alone, cut off, longer than needed, a surrogate, beyond the last character.
  EXPECT_EQ(Printable("\x9b"), "\\x9b");
  EXPECT_EQ(Printable("\xe6\x97"), "\\xe6\\x97");
  EXPECT_EQ(Printable("\xc0\xaf"), "\\xc0\\xaf");
  EXPECT_EQ(Printable("\xe0\x9f\xbf"), "\\xe0\\x9f\\xbf");
  EXPECT_EQ(Printable("\xed\xa0\x80"), "\\xed\\xa0\\x80");
  EXPECT_EQ(Printable("\xf4\x90\x80\x80"), "\\xf4\\x90\\x80\\x80");
  EXPECT_EQ(Printable("ü\xffü"), "ü\\xffü");
}

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
