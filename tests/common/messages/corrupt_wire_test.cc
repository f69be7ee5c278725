#include <gmock/gmock.h>

#include <algorithm>

#include "tests/common/messages/examples.h"
#include "tests/common/testing/allocation_guard.h"
#include "tests/common/testing/thrown.h"

// Bytes that are no well-formed message: the generated decoder must never see what it would
// believe.
namespace sprout {
namespace {

using examples::Encode;
using examples::Patched;
using ::testing::AnyOf;
using ::testing::HasSubstr;
using ::testing::StartsWith;

constexpr int32_t kHostileCounts[] = {-1,      -2,        INT32_MIN,     INT32_MIN + 1,
                                      1 << 20, 500000000, INT32_MAX - 1, INT32_MAX};

TEST(Wire, ExamplesAreValid) {
  for (const examples::Wire& wire : examples::AllWires()) {
    EXPECT_EQ(wire.ErrorOf(wire.bytes), "") << wire.name;
  }
}

TEST(Wire, RefusesTheFingerprintOfAnotherType) {
  const std::vector<examples::Wire> wires = examples::AllWires();
  for (const examples::Wire& wire : wires) {
    for (size_t i = 0; i < 8; ++i) {
      std::vector<uint8_t> bytes = wire.bytes;
      bytes[i] ^= 1;
      EXPECT_THAT(wire.ErrorOf(bytes), StartsWith("fingerprint is not that of ")) << wire.name;
    }
  }
  EXPECT_EQ(wires.front().ErrorOf(wires.back().bytes), "fingerprint is not that of image_t");
  EXPECT_EQ(wires.back().ErrorOf(wires.front().bytes), "fingerprint is not that of stage_status_t");
}

TEST(Wire, RefusesAMessageCutAnywhere) {
  for (const examples::Wire& wire : examples::AllWires()) {
    for (size_t size = 0; size < wire.bytes.size(); ++size) {
      // A copy of exactly that size, so that a sanitizer sees every byte read beyond it.
      const std::vector<uint8_t> bytes(wire.bytes.begin(),
                                       wire.bytes.begin() + static_cast<std::ptrdiff_t>(size));
      EXPECT_THAT(wire.ErrorOf(bytes),
                  AnyOf("message cut short", HasSubstr("fingerprint"), HasSubstr("does not fit")))
          << wire.name << " cut to " << size << " bytes";
    }
  }
}

TEST(Wire, RefusesBytesBehindTheMessage) {
  for (const examples::Wire& wire : examples::AllWires()) {
    std::vector<uint8_t> bytes = wire.bytes;
    bytes.push_back(0);
    EXPECT_EQ(wire.ErrorOf(bytes), "message has 1 bytes too many") << wire.name;
    bytes.resize(bytes.size() + 1000);
    EXPECT_EQ(wire.ErrorOf(bytes), "message has 1001 bytes too many") << wire.name;
  }
}

// Where a count stands on the wire, found by the encoder itself: the last byte of the count is the
// first that changes when the count shrinks by one (an odd one, so no borrow).
template <typename Message>
size_t CountOffset(const Message& message, int32_t Message::*count) {
  EXPECT_EQ(message.*count % 2, 1) << "the example needs an odd count";
  Message fewer = message;
  --(fewer.*count);
  const std::vector<uint8_t> a = Encode(message);
  const std::vector<uint8_t> b = Encode(fewer);
  return static_cast<size_t>(std::mismatch(b.begin(), b.end(), a.begin()).first - b.begin()) - 3;
}

template <typename Message>
void ExpectHostileCountsSeen(const Message& message, int32_t Message::*count, Part part) {
  const std::vector<uint8_t> bytes = Encode(message);
  const size_t offset = CountOffset(message, count);
  for (const int32_t hostile : kHostileCounts) {
    const std::vector<uint8_t> patched = Patched(bytes, offset, hostile);
    const AllocationGuard guard;
    const std::string error = WhyNot(DecodePart(part, patched));
    EXPECT_LT(guard.largest(), 100'000U) << hostile;
    // This text, and no other, proves that the count was seen before the generated decoder ran.
    EXPECT_THAT(error, StartsWith("array count " + std::to_string(hostile) + " does not fit"));
  }
}

template <typename Message>
void ExpectHostileCountsRefused(const Message& message, int32_t Message::*count, Part part) {
  ExpectHostileCountsSeen(message, count, part);
  const examples::Wire wire{"", Encode(message), part};
  const size_t offset = CountOffset(message, count);
  // Too large by little: the decoder finds the end.
  EXPECT_NE(wire.ErrorOf(Patched(wire.bytes, offset, message.*count + 1)), "");
  EXPECT_EQ(wire.ErrorOf(Patched(wire.bytes, offset, message.*count)), "");
}

TEST(Wire, RefusesHostileCountsOfAnImage) {
  ExpectHostileCountsRefused(ToMessage(examples::Id(), examples::GreyImage()), &image_t::size,
                             Part::kLeft);
}

TEST(Wire, RefusesHostileCountsOfATofImage) {
  const TofImage tof{.depth_m = cv::Mat1f(3, 5, 1.0F), .amplitude = cv::Mat1f(3, 5, 2.0F)};
  ExpectHostileCountsRefused(ToMessage(examples::Id(), tof), &tof_image_t::count, Part::kTof);
  ExpectHostileCountsRefused(ToMessage(examples::Id(), tof), &tof_image_t::amplitude_count,
                             Part::kTof);
}

TEST(Wire, RefusesHostileCountsOfSeeds) {
  ExpectHostileCountsRefused(ToMessage(examples::Id(), examples::Seeds()), &seeds_t::count,
                             Part::kSeeds);
}

TEST(Wire, RefusesHostileCountsOfADisparityImage) {
  disparity_image_t message =
      ToMessage(examples::Id(), examples::Disparity(), DisparityEncoding::kDeltaZstd);
  if (message.size % 2 == 0) {  // any odd count will do: the count is looked at first
    message.data.push_back(0);
    ++message.size;
    return ExpectHostileCountsSeen(message, &disparity_image_t::size, Part::kUnfilled);
  }
  ExpectHostileCountsRefused(message, &disparity_image_t::size, Part::kUnfilled);
}

TEST(Wire, RefusesHostileCountsOfAPrior) {
  const PriorMap prior(cv::Size(3, 1));
  prior_t message = ToMessage(examples::Id(), prior, DisparityEncoding::kRawInt16);
  ExpectHostileCountsRefused(message, &prior_t::sigma_size, Part::kPrior);
  message.data.push_back(0);  // an odd count, looked at first
  ++message.size;
  ExpectHostileCountsSeen(message, &prior_t::size, Part::kPrior);
}

TEST(Wire, RefusesHostileLengthsOfTheRigId) {
  for (const examples::Wire& wire : examples::AllWires()) {
    for (const int32_t length : {0, -1, INT32_MIN, INT32_MIN + 1, 1 << 20, INT32_MAX}) {
      EXPECT_EQ(wire.ErrorOf(Patched(wire.bytes, examples::kRigIdLengthOffset, length)),
                "header.rig_id: length " + std::to_string(length) + " does not fit")
          << wire.name;
    }
  }
}

// Each string of a message that carries no part, with the offset of its length.
using Strings = std::vector<std::pair<std::string, size_t>>;

Strings StringsBehind(const FrameId& header,
                      const std::vector<std::pair<std::string, std::string>>& fields) {
  size_t offset = examples::kRigIdLengthOffset + 4 + header.rig_id.size() + 1;
  Strings strings;
  for (const auto& [name, text] : fields) {
    strings.emplace_back(name, offset);
    offset += 4 + text.size() + 1;
  }
  return strings;
}

Strings StatusStrings() {
  const StageStatus status = examples::Status();
  return StringsBehind(status.newest_frame, {{"stage", status.stage},
                                             {"host", status.host},
                                             {"version", status.version},
                                             {"config_digest", status.config_digest},
                                             {"last_error", status.last_error}});
}

Strings ProcessStrings() {
  const ProcessInfo info = examples::Process();
  return StringsBehind(info.header, {{"stage", info.stage},
                                     {"host", info.host},
                                     {"version", info.version},
                                     {"config_digest", info.config_digest},
                                     {"config_text", info.config_text}});
}

TEST(Wire, RefusesHostileLengthsOfTheStringsOfStatusAndProcess) {
  const std::vector<examples::Wire> wires = examples::AllWires();
  const auto process = std::ranges::find(wires, "process", &examples::Wire::name);
  for (const auto& [wire, strings] :
       {std::pair(wires.back(), StatusStrings()), std::pair(*process, ProcessStrings())}) {
    for (const auto& [name, offset] : strings) {
      for (const int32_t length : {0, -1, -5, INT32_MIN, INT32_MIN + 1, 1 << 20, INT32_MAX}) {
        const std::vector<uint8_t> bytes = Patched(wire.bytes, offset, length);
        const AllocationGuard guard;
        EXPECT_EQ(wire.ErrorOf(bytes),
                  name + ": length " + std::to_string(length) + " does not fit");
        EXPECT_LT(guard.largest(), 100'000U);
      }
    }
  }
}

TEST(Wire, RefusesStringsThatDoNotEndWhereTheirLengthSays) {
  // They would change their length when they are sent on.
  for (const examples::Wire& wire : examples::AllWires()) {
    const size_t text = examples::kRigIdLengthOffset + 4;
    const size_t end = text + examples::Id().rig_id.size();
    std::vector<uint8_t> bytes = wire.bytes;
    bytes[text + 3] = 0;
    EXPECT_THAT(wire.ErrorOf(bytes), HasSubstr("header.rig_id")) << wire.name << ": ends inside";
    bytes = wire.bytes;
    bytes[end] = 'x';
    EXPECT_THAT(wire.ErrorOf(bytes), HasSubstr("header.rig_id")) << wire.name << ": does not end";
  }
  const examples::Wire status = examples::AllWires().back();
  for (const auto& [name, offset] : StatusStrings()) {
    std::vector<uint8_t> bytes = status.bytes;
    bytes[offset + 4 + 1] = 0;
    EXPECT_THAT(status.ErrorOf(bytes), StartsWith(name + ": "));
  }
}

}  // namespace
}  // namespace sprout
