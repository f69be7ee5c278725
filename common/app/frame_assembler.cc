#include "common/app/frame_assembler.h"

#include <exception>
#include <utility>

#include "common/bus/channels.h"
#include "common/messages/codec.h"

namespace sprout {

FrameAssembler::FrameAssembler(PartSet needed, StageMonitor& monitor, size_t max_pending)
    : monitor_(monitor), joiner_(needed, max_pending) {
  for (const Part part : kAllParts) {
    if (!needed.Has(part)) continue;
    parts_.push_back(part);
    channels_.push_back(ChannelOf(part));
  }
}

std::vector<Frame> FrameAssembler::Add(std::string_view channel, std::span<const uint8_t> bytes) {
  for (size_t i = 0; i < parts_.size(); ++i) {
    if (channels_[i] != channel) continue;
    try {
      const Result<FrameId> id = DecodeFrameId(bytes);
      Result<DecodedPart> part =
          DecodePart(parts_[i], bytes, id ? joiner_.ImageSizeOf(*id) : std::nullopt);
      if (!part) {
        monitor_.BadMessage(channel, part.error().text);
        return {};
      }
      std::vector<Frame> frames = joiner_.Add(part->id, parts_[i], std::move(part->value));
      monitor_.SetJoinerCounts(joiner_.incomplete(), joiner_.sequence_gaps());
      return frames;
    } catch (const std::exception& e) {  // out of memory: must not cross LCM's C frames
      monitor_.BadMessage(channel, e.what());
      return {};
    }
  }
  return {};
}

void FrameAssembler::Finish() {
  joiner_.DropPending();
  monitor_.SetJoinerCounts(joiner_.incomplete(), joiner_.sequence_gaps());
}

}  // namespace sprout
