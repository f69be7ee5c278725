#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace sprout {

/// Bytes of a message, in one row; not initialised when allocated. Copies share them.
struct MessageBytes {
  cv::Mat1b memory;

  /// @throws std::bad_alloc.
  static MessageBytes OfSize(size_t size);

  size_t size() const { return memory.total(); }
  operator std::span<const uint8_t>() const { return {memory.data, size()}; }
};

/// Assembles the messages of LCM's multicast protocol from their datagrams, which the network may
/// lose, reorder or duplicate. A message is delivered once, and only when every byte of it has
/// come. (liblcm 1.3.1 counts datagrams instead: if some come twice it delivers a message with
/// holes; and it trusts the numbers in a datagram.)
///
/// A short message is one datagram: "LC02", number of the message, channel, 0, data. A longer one
/// is several: "LC03", number of the message, size of the whole data, offset of this part, number
/// of this datagram, how many there are, and data, which in the first one follow channel and 0.
/// Numbers are big-endian and have 4 bytes, the last two 2; each sender counts its messages.
///
/// Not thread-safe; no I/O.
class DatagramJoiner {
 public:
  using Time = std::chrono::steady_clock::time_point;
  using Sender = std::pair<uint32_t, uint16_t>;  ///< address, port

  struct Message {
    std::string channel;
    MessageBytes bytes;
  };

  /// What a datagram of a longer message begins with: "LC03".
  static constexpr uint32_t kLongMagic = 0x4c433033;

  /// Largest message, as in LCM, bytes.
  static constexpr size_t kMaxMessageBytes = size_t{1} << 28;

  /// Most memory for unfinished messages, bytes; beyond it the oldest is dropped.
  static constexpr size_t kMaxPendingBytes = size_t{1} << 29;

  /// Most unfinished messages; beyond it the oldest is dropped.
  static constexpr size_t kMaxPending = 64;

  /// How long a delivered message is remembered, so that it is not delivered again.
  static constexpr std::chrono::seconds kRemembered{1};

  /// How many bytes of a channel's messages are of interest, from their beginning: 0 = none.
  using Wanted = std::function<size_t(std::string_view)>;

  explicit DatagramJoiner(Wanted wanted) : wanted_(std::move(wanted)) {}

  /// Takes one datagram, of any content.
  /// @returns the message that this datagram completed, if any.
  /// @throws std::bad_alloc.
  std::optional<Message> Add(const Sender& sender, std::span<const uint8_t> datagram, Time now);

 private:
  struct Name {
    Sender sender;
    uint32_t number;
    bool operator==(const Name&) const = default;
  };
  struct Pending {
    Name name;
    Message message;
    size_t message_bytes;
    std::vector<bool> has;  // by number of the datagram
    size_t missing_bytes;
    size_t wanted = kMaxMessageBytes;  // what lies behind is skipped
  };
  struct Fragment;

  std::optional<Message> AddShort(const Name& name, std::span<const uint8_t> rest, Time now);
  std::optional<Message> AddFragment(const Name& name, std::span<const uint8_t> rest, Time now);
  Pending* FindOrStart(const Name& name, const Fragment& fragment);
  void DropPending(const Pending& pending);
  bool IsDone(const Name& name, Time now);

  Wanted wanted_;
  std::deque<Pending> pending_;  // in order of arrival
  size_t pending_bytes_ = 0;
  std::deque<std::pair<Name, Time>> done_;  // delivered, the newest few
};

}  // namespace sprout
