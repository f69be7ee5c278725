#include "common/app/frame_assembler.h"

#include <exception>
#include <utility>

namespace sprout {

FrameAssembler::FrameAssembler(PartSet needed, StageMonitor& monitor, size_t max_pending,
                               PartSet optional)
    : monitor_(monitor),
      needed_(needed),
      joiner_(needed, max_pending, FrameJoiner::kDefaultMaxBytes, optional) {
  for (const Part part : kAllParts) {
    if (needed_.Has(part)) channels_.push_back(ChannelOf(part));
  }
}

std::vector<Frame> FrameAssembler::Add(std::string_view channel, std::span<const uint8_t> bytes) {
  const std::optional<Part> part = PartOf(channel);
  if (!part || !needed_.Has(*part)) return {};
  try {
    Result<std::vector<Frame>> frames = joiner_.AddMessage(*part, bytes);
    if (frames) {
      monitor_.SetJoinerCounts(joiner_.incomplete(), joiner_.sequence_gaps());
      return std::move(*frames);
    }
    monitor_.BadMessage(channel, frames.error().text);
  } catch (const std::exception& e) {  // out of memory
    monitor_.BadMessage(channel, e.what());
  }
  return {};
}

std::vector<Frame> FrameAssembler::Finish() {
  std::vector<Frame> last = joiner_.DropPending();
  monitor_.SetJoinerCounts(joiner_.incomplete(), joiner_.sequence_gaps());
  return last;
}

}  // namespace sprout
