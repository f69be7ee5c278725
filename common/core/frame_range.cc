#include "common/core/frame_range.h"

#include <charconv>

namespace sprout {
namespace {

// A frame number, or `otherwise` for an empty text.
std::optional<int64_t> ParseSeq(std::string_view text, std::optional<int64_t> otherwise) {
  if (text.empty()) return otherwise;
  int64_t seq = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), seq);
  if (error != std::errc() || end != text.data() + text.size() || seq < 0) return std::nullopt;
  return seq;
}

}  // namespace

std::optional<FrameRange> ParseFrameRange(std::string_view text) {
  const size_t colon = text.find(':');
  if (colon == std::string_view::npos) {
    const std::optional<int64_t> seq = ParseSeq(text, std::nullopt);
    if (!seq) return std::nullopt;
    return FrameRange{.first = *seq, .last = *seq};
  }
  if (text == ":") return std::nullopt;
  const FrameRange all;
  const std::optional<int64_t> first = ParseSeq(text.substr(0, colon), all.first);
  const std::optional<int64_t> last = ParseSeq(text.substr(colon + 1), all.last);
  if (!first || !last || *first > *last) return std::nullopt;
  return FrameRange{.first = *first, .last = *last};
}

}  // namespace sprout
