#include "common/config/frame_range.h"

#include <string_view>

#include "common/config/config_error.h"
#include "common/core/number_text.h"

namespace sprout {
namespace {

bool Read(std::string_view text, int64_t& number) {
  const auto read = ParseNumber<int64_t>(text);
  if (read) number = *read;
  return read && number >= 0;
}

}  // namespace

FrameRange ParseFrameRange(const std::string& flag, const std::string& text) {
  FrameRange frames;
  const std::string_view all = text;
  const size_t colon = all.find(':');
  const std::string_view first = all.substr(0, colon);
  const std::string_view last = colon == std::string_view::npos ? first : all.substr(colon + 1);
  const bool open = colon != std::string_view::npos;
  const bool understood = ((open && first.empty()) || Read(first, frames.first)) &&
                          ((open && last.empty()) || Read(last, frames.last));
  if (!understood || frames.first > frames.last) {
    throw ConfigError(
        flag + " " + text +
        ": allowed are A:B (frames A to B, both included, 0 <= A <= B), A:, :B and A");
  }
  return frames;
}

}  // namespace sprout
