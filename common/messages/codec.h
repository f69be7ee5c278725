#pragma once

#include <cstdint>
#include <opencv2/core/types.hpp>
#include <optional>
#include <span>
#include <vector>

#include "common/core/frame.h"
#include "common/core/process_info.h"
#include "common/core/result.h"
#include "common/core/rig_change.h"
#include "common/core/stage_status.h"
#include "common/messages/convert.h"

namespace sprout {

/// Bytes of a message of any type.
template <typename Message>
std::vector<uint8_t> EncodeMessage(const Message& message) {
  std::vector<uint8_t> bytes(static_cast<size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return bytes;
}

/// A decoded part.
struct DecodedPart {
  FrameId id;
  PartValue value;
};

/// Encodes a part as the bytes of its message, and decodes it. The type of the message follows from
/// that of the part's member in Frame (kPartTable, lcmtypes/README.md). Decoding accepts arbitrary
/// bytes: a wrong type, a size that does not fit or a hostile array count gives an error before
/// memory is allocated for it. A packed message (packed.h) is decoded as the one inside.
///
/// @param expected  size of the rectified images of this frame, if known. A compressed picture or
///                  map of another size is refused before it is decoded: a few bytes could expand
///                  to many. A raw one is accepted, and the stage reports in its answer what does
///                  not fit.
/// @param memory    whose data, in one row, `bytes` are, or empty. Images that are not compressed
///                  then share it, instead of being copied: nobody may change it any more.
std::vector<uint8_t> EncodePart(const FrameId& id, Part part, const PartValue& value,
                                DisparityEncoding encoding = DisparityEncoding::kRawInt16);
Result<DecodedPart> DecodePart(Part part, std::span<const uint8_t> bytes,
                               std::optional<cv::Size> expected = std::nullopt,
                               const cv::Mat1b& memory = {});

/// Bytes of a message on SPROUT_STATUS.
std::vector<uint8_t> EncodeStatus(const StageStatus& status);
Result<StageStatus> DecodeStatus(std::span<const uint8_t> bytes);

/// Bytes of a message on SPROUT_PROCESS.
std::vector<uint8_t> EncodeProcessInfo(const ProcessInfo& info);
Result<ProcessInfo> DecodeProcessInfo(std::span<const uint8_t> bytes);

/// Bytes of a message on SPROUT_RIG_CHANGE.
std::vector<uint8_t> EncodeRigChange(const RigChange& change);
Result<RigChange> DecodeRigChange(std::span<const uint8_t> bytes);

/// Only the header, with which every type of Sprout begins. The type is not checked, so check it
/// first (message_type.h). Reads only the header, O(1).
Result<FrameId> DecodeFrameId(std::span<const uint8_t> bytes);

}  // namespace sprout
