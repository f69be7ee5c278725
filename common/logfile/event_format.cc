#include "common/logfile/event_format.h"

#include <algorithm>
#include <bit>
#include <cstring>

namespace sprout {
namespace {

static_assert(std::endian::native == std::endian::little, "numbers in a log are big-endian");

int64_t Swap(int64_t value) {
  return static_cast<int64_t>(__builtin_bswap64(static_cast<uint64_t>(value)));
}

int32_t Swap(int32_t value) {
  return static_cast<int32_t>(__builtin_bswap32(static_cast<uint32_t>(value)));
}

template <typename T>
T Get(const uint8_t* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof value);
  return Swap(value);
}

template <typename T>
void Put(uint8_t* bytes, T value) {
  value = Swap(value);
  std::memcpy(bytes, &value, sizeof value);
}

}  // namespace

bool BeginsWithSync(std::span<const uint8_t> bytes) {
  const size_t count = std::min(bytes.size(), kSyncWord.size());
  return std::equal(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(count),
                    kSyncWord.begin());
}

std::optional<EventHeader> DecodeHeader(std::span<const uint8_t> bytes) {
  if (bytes.size() < kHeaderBytes) return std::nullopt;
  return EventHeader{.number = Get<int64_t>(&bytes[4]),
                     .utime = Get<int64_t>(&bytes[12]),
                     .channel_bytes = Get<int32_t>(&bytes[20]),
                     .data_bytes = Get<int32_t>(&bytes[24])};
}

bool IsPlausible(const EventHeader& header, std::span<const uint8_t> bytes) {
  if (header.channel_bytes < 1 || header.channel_bytes > kMaxChannelBytes) return false;
  if (header.data_bytes < 0) return false;
  const auto tail = bytes.subspan(kHeaderBytes);
  const auto channel = tail.first(std::min(tail.size(), static_cast<size_t>(header.channel_bytes)));
  return std::none_of(channel.begin(), channel.end(),
                      [](uint8_t c) { return c < 0x20 || c == 0x7f; });
}

std::array<uint8_t, kHeaderBytes> EncodeHeader(const EventHeader& header) {
  std::array<uint8_t, kHeaderBytes> bytes{};
  std::copy(kSyncWord.begin(), kSyncWord.end(), bytes.begin());
  Put(&bytes[4], header.number);
  Put(&bytes[12], header.utime);
  Put(&bytes[20], header.channel_bytes);
  Put(&bytes[24], header.data_bytes);
  return bytes;
}

}  // namespace sprout
