#include "common/messages/jpeg.h"

namespace sprout {
namespace {

// Markers of ITU-T T.81, table B.1; each stands behind a byte 0xff.
constexpr uint8_t kStartOfImage = 0xd8;
constexpr uint8_t kEndOfImage = 0xd9;
constexpr uint8_t kStartOfScan = 0xda;

// Start of frame, of whatever coding: C0 to CF without DHT (C4), JPG (C8) and DAC (CC).
bool IsStartOfFrame(uint8_t marker) {
  return marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc;
}

bool HasMarker(std::span<const uint8_t> data, size_t at, uint8_t marker) {
  return at + 2 <= data.size() && data[at] == 0xff && data[at + 1] == marker;
}

size_t ReadUint16(std::span<const uint8_t> data, size_t at) {
  return static_cast<size_t>(data[at] << 8 | data[at + 1]);
}

}  // namespace

std::optional<cv::Size> JpegSize(std::span<const uint8_t> data) {
  while (!data.empty() && data.back() == 0) data = data.first(data.size() - 1);
  if (data.size() < 4 || !HasMarker(data, 0, kStartOfImage) ||
      !HasMarker(data, data.size() - 2, kEndOfImage)) {
    return std::nullopt;
  }
  // Segments: marker, length (itself included), content. A frame header has precision (1 byte),
  // height and width (2 bytes each) behind its length.
  for (size_t at = 2; at + 9 <= data.size() && data[at] == 0xff;) {
    const uint8_t marker = data[at + 1];
    if (marker == 0xff) {  // fill byte
      ++at;
      continue;
    }
    if (marker == kStartOfScan) return std::nullopt;
    if (IsStartOfFrame(marker)) {
      return cv::Size(static_cast<int>(ReadUint16(data, at + 7)),
                      static_cast<int>(ReadUint16(data, at + 5)));
    }
    at += 2 + ReadUint16(data, at + 2);
  }
  return std::nullopt;
}

}  // namespace sprout
