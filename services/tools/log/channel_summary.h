#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "common/core/frame_id.h"
#include "common/core/process_info.h"
#include "common/logfile/log_reader.h"
#include "common/messages/message_type.h"

namespace sprout::log {

/// Whether messages of a type are parts of frames, of which there is one for each frame; unlike
/// statuses, and calibrations, which are sent again and again.
bool CarriesFrames(MessageType type);

/// Follows the frame numbers on one channel.
class Sequence {
 public:
  /// Missing frame numbers, both ends included.
  struct Gap {
    int64_t first = 0;
    int64_t last = 0;
  };

  void Add(const FrameId& id);

  /// Once all are added: only each `every`-th frame was sent, so the others are not missing.
  /// @param every  at least 1.
  void ExpectEvery(int64_t every);

  std::optional<int64_t> first() const { return first_; }  ///< smallest number of a frame
  std::optional<int64_t> last() const { return last_; }    ///< largest number of a frame
  int64_t missing() const { return missing_; }             ///< missing frame numbers
  int64_t repeated() const { return repeated_; }           ///< repeated frames
  int64_t late() const { return late_; }                   ///< frames that stand behind later ones
  int64_t times_back() const { return times_back_; }       ///< number rose, but utime did not
  int64_t restarts() const { return restarts_; }           ///< of capture, with smaller numbers
  const std::set<std::string>& rigs() const { return rigs_; }  ///< rig_id; at most kMaxRigs
  static constexpr size_t kMaxRigs = 16;

  /// The first few gaps as text: "7, 12-15"; "..." means others. After ExpectEvery() "3 in all".
  std::string GapText() const;

 private:
  std::optional<int64_t> first_;
  std::optional<int64_t> last_;
  std::optional<FrameId> newest_;
  std::deque<FrameId> recent_;
  std::vector<Gap> gaps_;  // the first few
  int64_t gap_count_ = 0;
  int64_t missing_ = 0;
  int64_t steps_ = 0;  // to larger numbers
  int64_t repeated_ = 0;
  int64_t late_ = 0;
  int64_t times_back_ = 0;
  int64_t restarts_ = 0;
  std::set<std::string> rigs_;
};

/// Summary of one channel of a log.
class ChannelSummary {
 public:
  /// Takes an event of the channel and decodes it if its type is Sprout's. On Sprout's channels any
  /// other type counts as undecodable, since services would refuse it.
  void Add(const LogEvent& event);

  const std::string& type() const { return type_; }  ///< of the first message, see NameOf()
  int64_t events() const { return events_; }
  int64_t bytes() const { return bytes_; }              ///< of the messages
  int64_t first_utime() const { return first_utime_; }  ///< of the events, µs
  int64_t last_utime() const { return last_utime_; }
  int64_t undecodable() const { return undecodable_; }
  const std::string& first_error() const { return first_error_; }  ///< with its event

  /// See Sequence.
  void ExpectEvery(int64_t every) { sequence_.ExpectEvery(every); }

  /// Whether each message belongs to one frame, unlike calibrations and statuses.
  bool has_frames() const { return has_frames_; }
  const Sequence& sequence() const { return sequence_; }

  /// Events a second, from first to last; NaN when there is one only.
  double rate_hz() const;

 private:
  std::string type_;
  int64_t events_ = 0;
  int64_t bytes_ = 0;
  int64_t first_utime_ = 0;
  int64_t last_utime_ = 0;
  int64_t undecodable_ = 0;
  std::string first_error_;
  bool has_frames_ = false;
  Sequence sequence_;
};

/// Why services would refuse a message: it is damaged, or of the wrong type for its channel. Empty
/// when it is valid or not of Sprout's types.
std::string WhyUndecodable(const LogEvent& event);

/// The processes in a log (SPROUT_PROCESS), each listed once although it sends the message every
/// few seconds.
class ProcessSummary {
 public:
  /// Takes a message; undecodable and repeated ones are ignored.
  void Add(std::span<const uint8_t> bytes);

  /// The processes in the order in which they came; at most kMaxProcesses.
  const std::vector<ProcessInfo>& processes() const { return processes_; }

  /// The newest process of a stage; null when there is none.
  const ProcessInfo* NewestOf(const std::string& stage) const;

  static constexpr size_t kMaxProcesses = 100;

 private:
  std::vector<ProcessInfo> processes_;
};

/// A line for each key that differs between the newest processes of a stage in two logs, and for
/// different versions; empty when all are equal.
std::string ConfigDiffText(const ProcessSummary& a, const ProcessSummary& b);

}  // namespace sprout::log
