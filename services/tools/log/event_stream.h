#pragma once

#include <compare>
#include <cstdint>
#include <deque>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "common/logfile/log_reader.h"
#include "services/tools/log/channel_summary.h"

namespace sprout::log {

/// The channels that a subcommand reads: those named, or all whose name begins with the prefix.
class ChannelFilter {
 public:
  /// @param names  without prefix; none: all.
  ChannelFilter(const std::vector<std::string>& names, std::string prefix);

  bool Has(std::string_view channel) const;

  const std::string& prefix() const { return prefix_; }
  const std::set<std::string, std::less<>>& names() const { return names_; }  ///< with prefix

 private:
  std::set<std::string, std::less<>> names_;
  std::string prefix_;
};

/// Key by which events of two logs are matched.
struct EventKey {
  std::string channel;
  int64_t utime = 0;    ///< of the header; 0 for calibrations and for messages without header
  int64_t seq = 0;      ///< of the header; for messages without header: how many came before
  std::string rig_id;   ///< of calibrations only, which are matched by it and not by frame
  int64_t version = 0;  ///< how many different messages with this header came before on the channel

  auto operator<=>(const EventKey&) const = default;
};

/// Position and content of an event, in a few bytes.
struct EventDigest {
  int64_t offset = 0;
  int64_t bytes = 0;
  uint64_t hash = 0;

  bool SameBytes(const EventDigest& other) const {
    return bytes == other.bytes && hash == other.hash;
  }
};

/// The events of a log that a diff compares, each with its key. Unless their channel is selected,
/// these are left out: statuses (they depend on the clock and the machine), SPROUT_PROCESS, and
/// LCM's self-test messages. Messages repeated with the same bytes, as when capture sends a frame
/// again, are always left out.
class EventStream {
 public:
  /// @throws LogError.
  EventStream(const std::filesystem::path& path, const ChannelFilter& filter);

  /// Reads up to the next event to compare. @returns false at the end.
  bool Next();

  const EventKey& key() const { return key_; }
  const EventDigest& digest() const { return digest_; }
  int64_t utime() const { return utime_; }  ///< time by which two streams are read in parallel, µs

  int64_t events() const { return events_; }  ///< compared so far
  /// The processes of all events read so far, also of those left out.
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
