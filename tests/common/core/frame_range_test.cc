#include "common/core/frame_range.h"

#include <gtest/gtest.h>

#include <limits>

namespace sprout {
namespace {

constexpr int64_t kMax = std::numeric_limits<int64_t>::max();

TEST(FrameRange, ReadsBothEndsEitherEndOrOneFrame) {
  EXPECT_EQ(ParseFrameRange("3:5"), (FrameRange{.first = 3, .last = 5}));
  EXPECT_EQ(ParseFrameRange("3:3"), (FrameRange{.first = 3, .last = 3}));
  EXPECT_EQ(ParseFrameRange("3:"), (FrameRange{.first = 3, .last = kMax}));
  EXPECT_EQ(ParseFrameRange(":5"), (FrameRange{.first = 0, .last = 5}));
  EXPECT_EQ(ParseFrameRange("7"), (FrameRange{.first = 7, .last = 7}));
  EXPECT_EQ(ParseFrameRange("0:9223372036854775807"), FrameRange());
}

TEST(FrameRange, RefusesWhatIsNone) {
  for (const char* text : {"", ":", "5:3", "-1:3", "a:b", "3:5:7", " 3:5", "3:5 ", "3-5", "+3:5",
                           "0x3:5", "9223372036854775808"}) {
    EXPECT_FALSE(ParseFrameRange(text)) << text;
  }
}

TEST(FrameRange, ContainsBothEnds) {
  const FrameRange range{.first = 3, .last = 5};
  EXPECT_FALSE(range.Contains(2));
  EXPECT_TRUE(range.Contains(3));
  EXPECT_TRUE(range.Contains(5));
  EXPECT_FALSE(range.Contains(6));
  EXPECT_TRUE(FrameRange().Contains(0));
}

}  // namespace
}  // namespace sprout
