#include "common/bus/channels.h"

#include <gtest/gtest.h>

#include <set>

namespace sprout {
namespace {

TEST(Channels, HaveANameOfTheirOwnForEachPart) {
  std::set<std::string_view> names = {kStatusChannel, kProcessChannel, kRigChangeChannel};
  for (const Part part : kAllParts) {
    EXPECT_TRUE(ChannelOf(part).starts_with("SPROUT_"));
    EXPECT_TRUE(names.insert(ChannelOf(part)).second) << ChannelOf(part);
  }
}

TEST(Channels, FitIntoLcmsLimitWithTheLongestPrefix) {
  for (const Part part : kAllParts) {
    EXPECT_LE(kMaxChannelPrefix + ChannelOf(part).size(), 63U);
  }
  EXPECT_LE(kMaxChannelPrefix + kStatusChannel.size(), 63U);
  EXPECT_LE(kMaxChannelPrefix + kProcessChannel.size(), 63U);
  EXPECT_LE(kMaxChannelPrefix + kRigChangeChannel.size(), 63U);
}

}  // namespace
}  // namespace sprout
