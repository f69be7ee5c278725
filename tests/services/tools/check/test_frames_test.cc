#include "services/tools/check/test_frames.h"

#include <gmock/gmock.h>

#include "common/bus/channels.h"
#include "common/config/config_error.h"
#include "common/messages/codec.h"

namespace sprout::check {
namespace {

using testing::SizeIs;

std::vector<TestFrame> SampleFrames(const std::string& stage) {
  return ReadTestFrames(std::string(SPROUT_SOURCE_DIR) + "/logs/sample.lcm", ContractOf(stage));
}

std::vector<uint8_t> Bytes(const TestFrame& frame, Part part) {
  return EncodePart({.utime = 1, .seq = 1, .rig_id = "id"}, part, frame.parts.at(part));
}

TEST(TestFrames, HoldWhatLiesUpstreamAndTheRecordedAnswer) {
  for (const std::string stage : {"refine", "prior", "grow"}) {
    const StageContract contract = ContractOf(stage);
    const auto frames = SampleFrames(stage);
    EXPECT_THAT(frames, SizeIs(5));
    for (const TestFrame& frame : frames) {
      EXPECT_THAT(frame.parts, SizeIs(contract.inputs.size()));
      EXPECT_FALSE(frame.parts.contains(contract.answer));
      ASSERT_TRUE(frame.recorded) << frame.name;
      EXPECT_FALSE(IsEmptyAnswer(*frame.recorded)) << frame.name;
    }
  }
}

TEST(TestFrames, PoorOnesDifferFromTheGoodOneAndLeaveItAsItWas) {
  const TestFrame good = SampleFrames("grow")[0];
  std::map<Part, std::vector<uint8_t>> before;
  for (const auto& [part, value] : good.parts) before[part] = Bytes(good, part);
  const auto poor = DegenerateFrames(good);
  EXPECT_THAT(poor, SizeIs(8));
  for (const TestFrame& frame : poor) {
    bool differs = false;
    for (const auto& [part, value] : frame.parts) differs |= Bytes(frame, part) != before[part];
    EXPECT_TRUE(differs) << frame.name;
  }
  for (const auto& [part, value] : good.parts) {
    EXPECT_EQ(Bytes(good, part), before[part]) << ChannelOf(part);
  }
}

TEST(TestFrames, ALogWithoutThemIsRefused) {
  const std::string log = std::string(SPROUT_SOURCE_DIR) + "/README.md";
  EXPECT_ANY_THROW(ReadTestFrames(log, ContractOf("prior")));
  EXPECT_THROW(ContractOf("capture"), ConfigError);
}

TEST(BadMessages, AreAllRefusedAtTheBorder) {
  const auto frames =
      ReadTestFrames(std::string(SPROUT_SOURCE_DIR) + "/logs/sample.lcm", ContractOf("grow"));
  const FrameId id{.utime = 1, .seq = 1, .rig_id = frames[0].rig_id};
  for (const auto& [part, value] : frames[0].parts) {
    const auto good = EncodePart(id, part, value);
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
