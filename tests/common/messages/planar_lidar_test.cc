#include "common/messages/planar_lidar.h"

#include <gtest/gtest.h>

#include <lcmtypes/bot_core/planar_lidar_t.hpp>
#include <limits>

#include "common/messages/codec.h"
#include "common/messages/message_type.h"

namespace sprout {
namespace {

const PlanarScan kScan{
    .ranges_m = {1.5F, std::numeric_limits<float>::infinity(), 2}, .first = -2, .step_rad = 0.25};

TEST(ScanMessage, IsOneThatOthersDecode) {
  const std::vector<uint8_t> bytes = EncodeScan({.utime = 12345, .seq = 7, .rig_id = "r"}, kScan);
  bot_core::planar_lidar_t message;
  ASSERT_EQ(message.decode(bytes.data(), 0, static_cast<int>(bytes.size())),
            static_cast<int>(bytes.size()));
  EXPECT_EQ(message.utime, 12345);
  EXPECT_EQ(message.nranges, 3);
  EXPECT_EQ(message.ranges, kScan.ranges_m);
  EXPECT_EQ(message.nintensities, 0);
  EXPECT_EQ(message.rad0, -0.5F);
  EXPECT_EQ(message.radstep, 0.25F);
}

TEST(ScanMessage, IsKnownByItsFingerprint) {
  const std::vector<uint8_t> bytes = EncodeScan({}, kScan);
  EXPECT_TRUE(IsScan(bytes));
  EXPECT_FALSE(IsScan({}));
  EXPECT_EQ(TypeOf(bytes), std::nullopt) << "it carries no part";
}

}  // namespace
}  // namespace sprout
