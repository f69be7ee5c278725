#include "common/messages/message_type.h"

#include <algorithm>
#include <array>
#include <utility>

#include "common/bus/channels.h"
#include "common/messages/packed.h"
#include "common/messages/packed_layout.h"

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

const std::array<KnownType, 14>& KnownTypes() {
  static const std::array<KnownType, 14> types = {Known<image_t>(MessageType::kImage),
                                                  Known<tof_image_t>(MessageType::kTof),
                                                  Known<rig_t>(MessageType::kRig),
                                                  Known<seeds_t>(MessageType::kSeeds),
                                                  Known<disparity_image_t>(MessageType::kDisparity),
                                                  Known<prior_t>(MessageType::kPrior),
                                                  Known<depth_image_t>(MessageType::kDepth),
                                                  Known<point_cloud_t>(MessageType::kCloud),
                                                  Known<motion_t>(MessageType::kMotion),
                                                  Known<depth_counts_t>(MessageType::kDepthCounts),
                                                  Known<tof_zones_t>(MessageType::kTofZones),
                                                  Known<stage_status_t>(MessageType::kStatus),
                                                  Known<process_info_t>(MessageType::kProcess),
                                                  Known<rig_change_t>(MessageType::kRigChange)};
  return types;
}

}  // namespace

std::string NameOf(MessageType type) { return KnownTypes()[static_cast<size_t>(type)].name; }

std::optional<uint64_t> FingerprintOf(std::span<const uint8_t> bytes) {
  if (bytes.size() < sizeof(uint64_t)) return std::nullopt;
  return FingerprintAt(bytes, 0);
}

std::optional<MessageType> TypeOf(std::span<const uint8_t> bytes) {
  const std::optional<uint64_t> fingerprint =
      IsPacked(bytes) ? PackedFingerprint(bytes) : FingerprintOf(bytes);
  for (const KnownType& known : KnownTypes()) {
    if (fingerprint == known.fingerprint) return known.type;
  }
  return std::nullopt;
}

MessageType TypeOf(Part part) { return static_cast<MessageType>(RowOf(part).member.index()); }

std::optional<MessageType> TypeOfChannel(std::string_view channel) {
  if (channel.ends_with(kStatusChannel)) return MessageType::kStatus;
  if (channel.ends_with(kProcessChannel)) return MessageType::kProcess;
  if (channel.ends_with(kRigChangeChannel)) return MessageType::kRigChange;
  for (const Part part : kAllParts) {
    if (channel.ends_with(ChannelOf(part))) return TypeOf(part);
  }
  return std::nullopt;
}

Result<DecodedMessage> DecodeAs(MessageType type, std::span<const uint8_t> bytes) {
  if (type == MessageType::kStatus) {
    return DecodeStatus(bytes).map([](StageStatus&& status) {
      return DecodedMessage{std::move(status.newest_frame), {}};
    });
  }
  if (type == MessageType::kProcess) {
    return DecodeProcessInfo(bytes).map([](ProcessInfo&& info) {
      return DecodedMessage{std::move(info.header), {}};
    });
  }
  if (type == MessageType::kRigChange) {
    return DecodeRigChange(bytes).map([](RigChange&& change) {
      return DecodedMessage{std::move(change.newest_frame), {}};
    });
  }
  // Any part of the type: decoding is the same for all of them, but that only a cloud in the
  // robot's frame may have any point.
  const auto any = std::ranges::find(kAllParts, type, [](Part part) { return TypeOf(part); });
  return DecodePart(type == MessageType::kCloud ? Part::kBaseCloud : *any, bytes)
      .map([](DecodedPart&& part) {
        return DecodedMessage{std::move(part.id), std::move(part.value)};
      });
}

}  // namespace sprout
