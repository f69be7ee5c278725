#include "services/tools/check/bad_messages.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/bus/channels.h"
#include "common/messages/codec.h"
#include "services/tools/check/test_frames.h"

namespace sprout::check {
namespace {

TEST(BadMessages, AreAllRefusedAtTheBorder) {
  const auto frames =
      ReadTestFrames(std::string(SPROUT_SOURCE_DIR) + "/logs/sample.lcm", ContractOf("grow"));
  const FrameId id{.utime = 1, .seq = 1, .rig_id = frames[0].rig_id};
  for (const auto& [part, value] : frames[0].parts) {
    const auto good = EncodePart(id, part, value, DisparityEncoding::kRawInt16);
    ASSERT_TRUE(DecodePart(part, good)) << ChannelOf(part);
    EXPECT_GE(CorruptionsOf(part).size(), 20U) << ChannelOf(part);
    for (const Corruption& corruption : CorruptionsOf(part)) {
      EXPECT_FALSE(DecodePart(part, corruption.apply(good)))
          << ChannelOf(part) << ", " << corruption.name;
    }
  }
}

}  // namespace
}  // namespace sprout::check
