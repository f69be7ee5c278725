#ifndef SPROUT_COMMON_BUS_DATAGRAM_JOINER_H_
#define SPROUT_COMMON_BUS_DATAGRAM_JOINER_H_

#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace sprout {

/// Bytes of a message that are not touched before they are written.
struct MessageBytes {
  std::unique_ptr<uint8_t[]> data;
  size_t size = 0;

  std::span<const uint8_t> span() const { return {data.get(), size}; }
};

/// Puts the messages of LCM's multicast protocol together from their datagrams, whatever the
/// network did to these: lost, in another order, several times. A message is given out once, and
/// only when every byte of it has come. (liblcm 1.3.1 counts datagrams instead: of a message whose
/// datagrams come twice it gives out a part, with holes; and it trusts the numbers in a datagram.)
///
/// A datagram is "LC02", number of the message, channel, 0, data; or, of a message that needs
/// several, "LC03", number, bytes of the whole data, place of these in it, number of this datagram,
/// how many there are, and data, in the first one behind channel and 0. Numbers are big-endian, of
/// 4 bytes, the last two of 2; each sender counts its messages.
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

  /// Largest message, as in LCM, bytes.
  static constexpr size_t kMaxMessageBytes = size_t{1} << 28;

  /// Memory that unfinished messages may ask for; beyond it the oldest is dropped.
  static constexpr size_t kMaxPendingBytes = size_t{1} << 29;

  /// Unfinished messages that are kept; beyond it the oldest is dropped.
  static constexpr size_t kMaxPending = 64;

  /// How long a whole message is remembered, so that it is not given out again.
  static constexpr std::chrono::seconds kRemembered{1};

  /// @param is_wanted  whether messages of a channel are of interest.
  explicit DatagramJoiner(std::function<bool(std::string_view)> is_wanted)
      : is_wanted_(std::move(is_wanted)) {}

  /// Takes one datagram, of any content.
  /// @returns the message that is whole now.
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
    bool wanted = true;  // if not, the rest is only passed over
  };
  struct Fragment;

  std::optional<Message> AddShort(const Name& name, std::span<const uint8_t> rest, Time now);
  std::optional<Message> AddFragment(const Name& name, std::span<const uint8_t> rest, Time now);
  Pending* FindOrStart(const Name& name, const Fragment& fragment);
  void DropPending(const Pending& pending);
  bool IsDone(const Name& name, Time now);

  std::function<bool(std::string_view)> is_wanted_;
  std::deque<Pending> pending_;  // in order of arrival
  size_t pending_bytes_ = 0;
  std::deque<std::pair<Name, Time>> done_;  // given out, the newest few
};

}  // namespace sprout

#endif  // SPROUT_COMMON_BUS_DATAGRAM_JOINER_H_
