#ifndef SPROUT_COMMON_MESSAGES_CODEC_H_
#define SPROUT_COMMON_MESSAGES_CODEC_H_

#include <cstdint>
#include <opencv2/core/types.hpp>
#include <optional>
#include <span>
#include <vector>

#include "common/core/frame.h"
#include "common/core/process_info.h"
#include "common/core/result.h"
#include "common/core/stage_status.h"
#include "common/messages/convert.h"

namespace sprout {

/// A part as it came off the wire.
struct DecodedPart {
  FrameId id;
  PartValue value;
};

/// Bytes of the message that carries a part, and back. The type of the message follows from that
/// of the part's member in Frame (kPartTable, lcmtypes/README.md). Decoding survives any bytes: a
/// wrong type, a size that does not fit or a hostile array count yields an error before memory is
/// taken for it.
///
/// @param expected  size that the rectified images of this frame have, where it is known. A
///                  compressed picture or map of another size is refused before it is decoded: a
///                  few bytes could ask for a lot. One that brings all its bytes is let through,
///                  and the stage says in its answer what does not fit together.
std::vector<uint8_t> EncodePart(const FrameId& id, Part part, const PartValue& value,
                                DisparityEncoding encoding);
Result<DecodedPart> DecodePart(Part part, std::span<const uint8_t> bytes,
                               std::optional<cv::Size> expected = std::nullopt);

/// The same for SPROUT_STATUS.
std::vector<uint8_t> EncodeStatus(const StageStatus& status);
Result<StageStatus> DecodeStatus(std::span<const uint8_t> bytes);

/// The same for SPROUT_PROCESS.
std::vector<uint8_t> EncodeProcessInfo(const ProcessInfo& info);
Result<ProcessInfo> DecodeProcessInfo(std::span<const uint8_t> bytes);

/// The header alone, which every type of ours begins with; whatever type the bytes claim to be, so
/// look at the type first (message_type.h). Takes no more than the header, O(1).
Result<FrameId> DecodeFrameId(std::span<const uint8_t> bytes);

}  // namespace sprout

#endif  // SPROUT_COMMON_MESSAGES_CODEC_H_
