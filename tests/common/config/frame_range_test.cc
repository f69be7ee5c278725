#include "common/config/frame_range.h"

#include <gtest/gtest.h>

#include "common/config/config_error.h"

namespace sprout {
namespace {

TEST(FrameRange, IsReadWithBothEndsIncluded) {
  EXPECT_EQ(ParseFrameRange("--frames", "3:7"), (FrameRange{3, 7}));
  EXPECT_EQ(ParseFrameRange("--frames", "5"), (FrameRange{5, 5}));
  EXPECT_EQ(ParseFrameRange("--frames", "5:"), (FrameRange{5, FrameRange().last}));
  EXPECT_EQ(ParseFrameRange("--frames", ":5"), (FrameRange{0, 5}));
  EXPECT_EQ(ParseFrameRange("--frames", ":"), FrameRange());
  EXPECT_TRUE((FrameRange{3, 7}).Has(3));
  EXPECT_TRUE((FrameRange{3, 7}).Has(7));
  EXPECT_FALSE((FrameRange{3, 7}).Has(2));
  EXPECT_FALSE((FrameRange{3, 7}).Has(8));
}

TEST(FrameRange, RefusesOtherTexts) {
  for (const char* text :
       {"", "a", "3:b", "7:3", "-1", "-1:2", "1:2:3", "1-2", " 1", "99999999999999999999"}) {
    EXPECT_THROW(ParseFrameRange("--frames", text), ConfigError) << text;
  }
}

}  // namespace
}  // namespace sprout
