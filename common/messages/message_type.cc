#include "common/messages/message_type.h"

#include <array>
#include <utility>

namespace sprout {
namespace {

struct KnownType {
  MessageType type;
  std::string name;
  uint64_t fingerprint;
};

template <typename Message>
KnownType Known(MessageType type) {
  return {type, std::string("sprout.") + Message::getTypeName(),
          static_cast<uint64_t>(Message::getHash())};
}

const std::array<KnownType, 7>& KnownTypes() {
  static const std::array<KnownType, 7> types = {Known<image_t>(MessageType::kImage),
                                                 Known<tof_image_t>(MessageType::kTof),
                                                 Known<rig_t>(MessageType::kRig),
                                                 Known<seeds_t>(MessageType::kSeeds),
                                                 Known<prior_t>(MessageType::kPrior),
                                                 Known<disparity_image_t>(MessageType::kDisparity),
                                                 Known<stage_status_t>(MessageType::kStatus)};
  return types;
}

// Any part of a type: decoding is the same for all of them.
Part PartOf(MessageType type) {
  switch (type) {
    case MessageType::kImage:
      return Part::kLeft;
    case MessageType::kTof:
      return Part::kTof;
    case MessageType::kRig:
      return Part::kRig;
    case MessageType::kSeeds:
      return Part::kSeeds;
    case MessageType::kPrior:
      return Part::kPrior;
    case MessageType::kDisparity:
    case MessageType::kStatus:
      break;
  }
  return Part::kDisparity;
}

}  // namespace

std::string NameOf(MessageType type) { return KnownTypes()[static_cast<size_t>(type)].name; }

std::optional<uint64_t> FingerprintOf(std::span<const uint8_t> bytes) {
  if (bytes.size() < sizeof(uint64_t)) return std::nullopt;
  uint64_t fingerprint = 0;
  for (const uint8_t byte : bytes.first(sizeof(uint64_t))) fingerprint = fingerprint << 8 | byte;
  return fingerprint;
}

std::optional<MessageType> TypeOf(std::span<const uint8_t> bytes) {
  const std::optional<uint64_t> fingerprint = FingerprintOf(bytes);
  for (const KnownType& known : KnownTypes()) {
    if (fingerprint == known.fingerprint) return known.type;
  }
  return std::nullopt;
}

MessageType TypeOf(Part part) {
  switch (part) {
    case Part::kLeft:
    case Part::kRight:
    case Part::kConfidence:
      return MessageType::kImage;
    case Part::kTof:
      return MessageType::kTof;
    case Part::kRig:
      return MessageType::kRig;
    case Part::kSeeds:
    case Part::kLeftSeeds:
      return MessageType::kSeeds;
    case Part::kPrior:
      return MessageType::kPrior;
    case Part::kUnfilled:
    case Part::kDisparity:
      break;
  }
  return MessageType::kDisparity;
}

Result<DecodedMessage> DecodeAs(MessageType type, std::span<const uint8_t> bytes) {
  if (type == MessageType::kStatus) {
    Result<StageStatus> status = DecodeStatus(bytes);
    if (!status) return tl::unexpected(status.error());
    return DecodedMessage{std::move(status->newest_frame), {}};
  }
  Result<DecodedPart> part = DecodePart(PartOf(type), bytes);
  if (!part) return tl::unexpected(part.error());
  return DecodedMessage{std::move(part->id), std::move(part->value)};
}

}  // namespace sprout
