#ifndef SPROUT_SERVICES_LOG_EVENT_STREAM_H_
#define SPROUT_SERVICES_LOG_EVENT_STREAM_H_

#include <compare>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>

#include "common/logfile/log_reader.h"
#include "services/log/channels.h"
#include "services/log/process_summary.h"

namespace sprout::log {

/// What makes two events of two logs counterparts.
struct EventKey {
  std::string channel;
  int64_t utime = 0;    ///< of the header; 0 for calibrations and for messages without header
  int64_t seq = 0;      ///< of the header; for messages without header: how many came before
  std::string rig_id;   ///< calibrations only, which are found by it and not by frame
  int64_t version = 0;  ///< how many different messages with this header came before on the channel

  auto operator<=>(const EventKey&) const = default;
};

/// Where an event is, and what it holds, in a few bytes.
struct EventDigest {
  int64_t offset = 0;
  int64_t bytes = 0;
  uint64_t hash = 0;

  bool SameBytes(const EventDigest& other) const {
    return bytes == other.bytes && hash == other.hash;
  }
};

/// The events of a log that a diff compares, each with its key. Left out are, unless their channel
/// is asked for, statuses (they tell of the clock and the machine), what processes say of
/// themselves and what LCM says to itself when a program connects; and always messages that were
/// recorded again with the same bytes, as happens when capture sends a frame again.
class EventStream {
 public:
  /// @throws LogError.
  EventStream(const std::filesystem::path& path, const ChannelFilter& filter);

  /// Reads on until the next event to compare. @returns false at the end.
  bool Next();

  const EventKey& key() const { return key_; }
  const EventDigest& digest() const { return digest_; }
  int64_t utime() const { return utime_; }  ///< by which two streams are kept abreast, µs

  int64_t events() const { return events_; }  ///< compared so far
  /// Of the events that were read, left out or not.
  const ProcessSummary& processes() const { return processes_; }
  int64_t repeated() const { return repeated_; }  ///< left out as repeated; without calibrations
  const LogReader& reader() const { return reader_; }

 private:
  struct Recent {
    EventKey key;  // with version 0
    EventDigest digest;
  };

  void SetKey(const LogEvent& event);
  bool IsRepeated();

  LogReader reader_;
  const ChannelFilter& filter_;
  EventKey key_;
  EventDigest digest_;
  int64_t utime_ = 0;
  int64_t events_ = 0;
  int64_t repeated_ = 0;
  ProcessSummary processes_;
  std::map<std::string, int64_t> headerless_;         // messages without header, by channel
  std::map<std::string, std::deque<Recent>> recent_;  // the newest few, by channel
};

}  // namespace sprout::log

#endif  // SPROUT_SERVICES_LOG_EVENT_STREAM_H_
