#pragma once

#include <atomic>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "common/app/service_context.h"
#include "common/app/silence_watch.h"
#include "common/app/stage_monitor.h"
#include "common/bus/receiver.h"
#include "common/core/frame.h"
#include "common/frames/sequence_gaps.h"
#include "common/messages/compressor.h"
#include "services/record/event_ring.h"
#include "services/record/log_folder.h"

namespace sprout::record {

struct RingOptions {
  RecordedEvent::Clock::duration length{};  ///< time kept before a trigger
  size_t max_bytes = 0;                     ///< memory for it
  RecordedEvent::Clock::duration after{};   ///< time recorded after a trigger
};

/// Decides which messages are written. Without a ring: every one. With a ring: nothing until a
/// trigger comes, then the ring and the following messages, in one log. If the ring of a later
/// trigger still contains a message of the previous log, that log is continued. So no message is
/// written twice, however fast triggers come, and a log has all messages from its first trigger's
/// ring to its end. A log stays open as long as it may be continued. Time is that of the messages,
/// so a slow disk does not change what is recorded. Not thread-safe.
class Recorder {
 public:
  using Time = RecordedEvent::Clock::time_point;

  /// @param folder  must outlive this.
  Recorder(const std::optional<RingOptions>& ring, LogFolder& folder);

  /// @throws LogError, see LogFolder::Write().
  void Add(RecordedEvent event);

  /// The recorder's own status: as Add(), but it does not begin a log.
  void AddStatus(RecordedEvent event);

  /// A trigger. Does nothing without a ring.
  /// @returns true when a log begins, false when one continues. @throws LogError.
  bool Trigger(Time now);

  /// Ends the open log. @throws LogError.
  void Finish() { folder_.Close(); }

  /// Messages that were to be written and were not: 0 until something above has thrown.
  int64_t unwritten() const { return unwritten_; }

  /// The ring; nullptr: there is none.
  const EventRing* ring() const { return ring_ ? &*ring_ : nullptr; }

 private:
  void Write(const RecordedEvent& event);
  void WriteMissing();
  void CloseIfApart();

  LogFolder& folder_;
  RecordedEvent::Clock::duration after_{};
  std::optional<EventRing> ring_;
  std::optional<Time> until_;  // end of the open log; none: no open log
  size_t missing_ = 0;         // newest messages of the ring that are not in the open log
  int64_t unwritten_ = 0;
};

struct RecordingOptions {
  std::vector<std::string> channels;  ///< without prefix
  bool named = false;                 ///< whether --channels named these
  LogFolderOptions folder;
  std::optional<RingOptions> ring;
  std::optional<std::string> trigger_channel;  ///< without prefix; any message on it
  std::optional<double> trigger_confidence;    ///< a mean confidence (0 to 1) below it
  bool compress = false;                       ///< see MessageCompressor
  std::optional<int> jpeg_quality;             ///< of images, with `compress`
};

/// Records the running graph. One thread receives messages and never waits for the disk; another
/// one writes. While 512 MB wait to be written, new messages are dropped and counted as bad ones.
class Recording {
 public:
  /// @param monitor  counts losses; its status is written into the log.
  /// @throws ConfigError for a folder that cannot be used, BusError, see OpenLcm().
  Recording(const ServiceContext& context, RecordingOptions options, StageMonitor& monitor);

  ~Recording() { queue_.Close(); }
  Recording(const Recording&) = delete;
  Recording& operator=(const Recording&) = delete;

  /// Triggers: records the ring.
  /// @param who  source of the trigger, for people.
  void Trigger(const std::string& who);

  /// Writes the recorder's own status into the log. Call once a second; it also advances time.
  void PutStatus();

  /// Whether writing failed for good; the monitor has the reason.
  bool has_failed() const { return failed_; }

  /// Bytes that wait to be written.
  size_t waiting_bytes() const { return queue_.bytes(); }

  /// Stops receiving, writes what waits, and ends the log. Call once.
  void Finish();

  /// Whether the recording is without loss; after Finish().
  bool IsWhole() const;

  /// Counts of written and lost messages, in one line; after Finish().
  std::string Summary() const;

 private:
  RecordedEvent MakeEvent(std::string channel, std::span<const uint8_t> bytes) const;
  RecordedEvent StatusEvent() const;
  bool IsOwn(std::string_view channel, std::span<const uint8_t> bytes) const;
  bool IsRecorded(std::string_view channel) const;
  void Receive(std::string_view channel, std::span<const uint8_t> bytes);
  void Drop(std::string_view channel);
  void Hear(std::string_view channel);
  void CountFrame(Part part, std::span<const uint8_t> bytes);
  void WriteAll();
  void Handle(QueuedEvent item);
  void HandleTrigger(RecordedEvent::Clock::time_point now, const std::string& who);
  void CheckConfidence(const RecordedEvent& event);
  void Compress(RecordedEvent& event);
  void Fail(const std::string& reason);

  RecordingOptions options_;
  std::string prefix_;
  StageMonitor& monitor_;
  int32_t depth_every_;                       // frames; sprout-depth publishes the first of so many
  std::optional<Part> counted_part_;          // whose messages are counted as frames
  std::map<Part, SequenceGaps> gaps_;         // of the receiving thread
  std::set<std::string, std::less<>> heard_;  // recorded channels with messages; of that thread
  bool heard_trigger_ = false;                // on trigger_channel; of that thread
  int64_t unjudged_ = 0;                      // frames since the newest confidence; of that thread
  std::atomic<int64_t> dropped_ = 0;          // messages that did not fit into the queue
  int64_t triggers_ = 0;                      // used by the writing thread, as all below
  int64_t unwritten_ = 0;                     // messages lost since writing failed
  std::optional<MessageCompressor> compressor_;
  int64_t uncompressed_bytes_ = 0;  // of the messages that were compressed
  int64_t compressed_bytes_ = 0;
  std::atomic<bool> failed_ = false;
  EventQueue queue_;
  LogFolder folder_;
  Recorder recorder_;
  std::jthread writing_;
  std::optional<SilenceWatch> silence_;
  std::optional<Receiver> receiver_;
};

}  // namespace sprout::record
