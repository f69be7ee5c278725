#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

// The bytes of one event in a log of LCM: sync word, header, channel, data; numbers big-endian.
namespace sprout {

inline constexpr std::array<uint8_t, 4> kSyncWord = {0xED, 0xA1, 0xDA, 0x01};

/// Sync word (4), number (8), utime (8), length of channel (4) and of data (4).
inline constexpr int64_t kHeaderBytes = 28;

/// LCM's limit on the name of a channel.
inline constexpr int64_t kMaxChannelBytes = 63;

/// Bytes needed to check a header: itself and the channel.
inline constexpr int64_t kMaxHeadBytes = kHeaderBytes + kMaxChannelBytes;

/// The smallest event: a channel of one character and no data.
inline constexpr int64_t kMinEventBytes = kHeaderBytes + 1;

struct EventHeader {
  int64_t number = 0;
  int64_t utime = 0;  ///< µs
  int32_t channel_bytes = 0;
  int32_t data_bytes = 0;

  /// Bytes from its sync word to the next one.
  int64_t event_bytes() const { return kHeaderBytes + channel_bytes + data_bytes; }
};

/// Whether the bytes begin with a sync word, or are the beginning of one.
bool BeginsWithSync(std::span<const uint8_t> bytes);

/// The header at the beginning of `bytes`, unchecked; nothing when it is cut short.
std::optional<EventHeader> DecodeHeader(std::span<const uint8_t> bytes);

/// Whether an event may have these lengths and, as far as `bytes` contain it, this channel: 1 to 63
/// characters as LCM requires, and no control characters, as Sprout requires.
bool IsPlausible(const EventHeader& header, std::span<const uint8_t> bytes);

std::array<uint8_t, kHeaderBytes> EncodeHeader(const EventHeader& header);

}  // namespace sprout
