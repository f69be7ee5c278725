// What comes over the network: single messages, and messages that make frames.
#include <gtest/gtest.h>

#include <algorithm>
#include <utility>

#include "common/frames/frame_joiner.h"
#include "common/messages/codec.h"
#include "tests/common/messages/examples.h"
#include "tests/fuzz/targets.h"

namespace sprout::fuzz {
namespace {

constexpr size_t kFingerprintBytes = 8;
constexpr size_t kMaxResentBytes = 1 << 20;  // of what is sent on; more only takes time

const std::vector<examples::Wire>& Wires() {
  static const std::vector<examples::Wire> wires = examples::AllWires();
  return wires;
}

// An input leaves the fingerprint out: guessing it would take most of the time.
Bytes WithFingerprint(const examples::Wire& wire, std::span<const uint8_t> rest) {
  Bytes bytes(wire.bytes.begin(), wire.bytes.begin() + kFingerprintBytes);
  bytes.insert(bytes.end(), rest.begin(), rest.end());
  return bytes;
}

void Append(Bytes& bytes, std::span<const uint8_t> more) {
  bytes.insert(bytes.end(), more.begin(), more.end());
}

size_t DecodedBytesOf(const PartValue& value, Part part) {
  Frame frame;
  SetPart(frame, part, value);
  return sprout::BytesOf(frame);
}

// What passes the border is a good value: a stage may send it on, and it passes again.
void CheckSentOn(Part part, const DecodedPart& decoded) {
  if (DecodedBytesOf(decoded.value, part) > kMaxResentBytes) return;
  for (const auto encoding : {DisparityEncoding::kRawInt16, DisparityEncoding::kDeltaZstd}) {
    const Result<DecodedPart> again =
        DecodePart(part, EncodePart(decoded.id, part, decoded.value, encoding));
    Check(again.has_value(), again ? "" : "sent on, it is refused: " + again.error().text);
    Check(again->id == decoded.id, "sent on, it has another name");
  }
}

}  // namespace

void DecodeMessage(std::span<const uint8_t> bytes) {
  Reader reader(bytes);
  const examples::Wire& wire = Wires()[reader.Byte() % Wires().size()];
  const Bytes message = WithFingerprint(wire, reader.rest());
  const Result<FrameId> id = DecodeFrameId(message);
  if (!wire.part) {
    (void)wire.ErrorOf(message);
    const Result<StageStatus> status = DecodeStatus(message);
    if (status) Check(DecodeStatus(EncodeStatus(*status)).has_value(), "a status is refused");
    return;
  }
  const Result<DecodedPart> decoded = DecodePart(*wire.part, message);
  if (!decoded) return;
  Check(id && *id == decoded->id, "the header alone says something else");
  CheckSentOn(*wire.part, *decoded);
}

std::vector<Bytes> MessageSeeds() {
  std::vector<Bytes> seeds;
  for (size_t i = 0; i < Wires().size(); ++i) {
    seeds.push_back({static_cast<uint8_t>(i)});
    Append(seeds.back(), std::span(Wires()[i].bytes).subspan(kFingerprintBytes));
  }
  return seeds;
}

// An input is a series of messages: which part, which type, how many bytes, and these.
void JoinMessages(std::span<const uint8_t> bytes) {
  FrameJoiner joiner(
      {Part::kLeft, Part::kRight, Part::kTof, Part::kRig, Part::kSeeds, Part::kPrior});
  int64_t sent = 0;
  int64_t complete = 0;
  for (Reader reader(bytes); !reader.rest().empty();) {
    const Part part = kAllParts[reader.Byte() % kAllParts.size()];
    const examples::Wire& wire = Wires()[reader.Byte() % Wires().size()];
    const size_t size = reader.Short();
    const Bytes message = WithFingerprint(wire, reader.Take(size));
    const Result<FrameId> id = DecodeFrameId(message);
    Result<DecodedPart> decoded =
        DecodePart(part, message, id ? joiner.ImageSizeOf(*id) : std::nullopt);
    if (!decoded) continue;
    ++sent;
    for (const Frame& frame : joiner.Add(decoded->id, part, std::move(decoded->value))) {
      ++complete;
      Check(!frame.left.empty() && !frame.right.empty() && frame.tof && frame.rig && frame.seeds &&
                frame.prior,
            "a frame is called complete, and is not");
    }
  }
  joiner.DropPending();
  Check(joiner.incomplete() + complete <= sent, "more was counted than was sent");
}

std::vector<Bytes> FrameSeeds() {
  const FrameId id = examples::Id();
  Rig rig = examples::Rig();
  rig.pair.width = 7;
  rig.pair.height = 5;
  const std::pair<Part, PartValue> parts[] = {
      {Part::kRig, rig},
      {Part::kLeft, examples::GreyImage()},
      {Part::kRight, examples::GreyImage()},
      {Part::kTof, examples::Tof(true)},
      {Part::kSeeds, examples::Seeds()},
      {Part::kPrior, PriorMap(cv::Size(7, 5))},
  };
  Bytes seed;
  for (const auto& [part, value] : parts) {
    const Bytes message = EncodePart(id, part, value, DisparityEncoding::kDeltaZstd);
    const auto same_type = [&](const examples::Wire& wire) {
      return std::equal(message.begin(), message.begin() + kFingerprintBytes, wire.bytes.begin());
    };
    const auto wire = std::ranges::find_if(Wires(), same_type) - Wires().begin();
    const size_t size = message.size() - kFingerprintBytes;
    seed.push_back(static_cast<uint8_t>(part));
    seed.push_back(static_cast<uint8_t>(wire));
    seed.push_back(static_cast<uint8_t>(size & 0xff));
    seed.push_back(static_cast<uint8_t>(size >> 8));
    Append(seed, std::span(message).subspan(kFingerprintBytes));
  }
  Bytes twice = seed;
  Append(twice, seed);
  return {seed, twice};
}

}  // namespace sprout::fuzz
