#include "common/messages/message_type.h"

#include <gtest/gtest.h>

#include "tests/common/messages/examples.h"

namespace sprout {
namespace {

TEST(MessageType, IsToldByTheFingerprint) {
  for (const examples::Wire& wire : examples::AllWires()) {
    const std::optional<MessageType> type = TypeOf(wire.bytes);
    ASSERT_TRUE(type.has_value()) << wire.name;
    EXPECT_EQ(*type, wire.part ? TypeOf(*wire.part) : wire.other) << wire.name;
    EXPECT_TRUE(DecodeAs(*type, wire.bytes).has_value()) << wire.name;
  }
  EXPECT_EQ(TypeOf(std::vector<uint8_t>(100)), std::nullopt);
  EXPECT_EQ(TypeOf(std::vector<uint8_t>(7)), std::nullopt);
  EXPECT_EQ(NameOf(MessageType::kStatus), "sprout.stage_status_t");
  EXPECT_EQ(NameOf(MessageType::kImage), "sprout.image_t");
}

TEST(MessageType, HeaderIsReadAlone) {
  for (const examples::Wire& wire : examples::AllWires()) {
    // Nothing behind the header is looked at.
    const std::span<const uint8_t> head =
        std::span(wire.bytes).first(28 + examples::Id().rig_id.size() + 1);
    const Result<FrameId> id = DecodeFrameId(head);
    ASSERT_TRUE(id.has_value()) << wire.name << ": " << id.error().text;
    EXPECT_EQ(*id, examples::Id()) << wire.name;
    EXPECT_FALSE(DecodeFrameId(head.first(head.size() - 1)).has_value()) << wire.name;
  }
  EXPECT_FALSE(DecodeFrameId({}).has_value());
}

TEST(MessageType, HeaderWithABadRigIdIsRefused) {
  const std::vector<uint8_t> good = examples::AllWires().front().bytes;
  for (const int length : {-1, 0, 16, 18, 1 << 30}) {
    EXPECT_FALSE(
        DecodeFrameId(examples::Patched(good, examples::kRigIdLengthOffset, length)).has_value())
        << length;
  }
}

}  // namespace
}  // namespace sprout
