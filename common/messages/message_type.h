#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>

#include "common/core/frame.h"
#include "common/core/result.h"
#include "common/core/stage_status.h"
#include "common/messages/codec.h"

namespace sprout {

/// Sprout's message types: first those that carry parts, in the order of the alternatives of
/// PartMember.
enum class MessageType {
  kImage,
  kTof,
  kRig,
  kSeeds,
  kDisparity,
  kPrior,
  kDepth,
  kCloud,
  kMotion,
  kDepthCounts,
  kTofZones,
  kStatus,
  kProcess,
  kRigChange
};

/// "sprout.image_t", ...: as in lcmtypes.
std::string NameOf(MessageType type);

/// The first 8 bytes of an LCM message, which identify its type; nothing when there are fewer.
std::optional<uint64_t> FingerprintOf(std::span<const uint8_t> bytes);

/// Type by fingerprint, of a packed message that of the message inside; nothing when it is not one
/// of Sprout's.
std::optional<MessageType> TypeOf(std::span<const uint8_t> bytes);

/// The type that carries a part.
MessageType TypeOf(Part part);

/// The type that a channel of Sprout must carry, with any prefix; nothing for another channel.
std::optional<MessageType> TypeOfChannel(std::string_view channel);

/// Decodes a message of one of Sprout's types without knowing its part; with the checks of
/// DecodePart(), DecodeStatus(), DecodeProcessInfo() and DecodeRigChange().
/// @returns the value of a part, or nothing (std::monostate) for what is no part of a frame.
struct DecodedMessage {
  FrameId id;
  std::variant<std::monostate, PartValue> value;
};
Result<DecodedMessage> DecodeAs(MessageType type, std::span<const uint8_t> bytes);

}  // namespace sprout
