#ifndef SPROUT_SERVICES_RECORD_RECORDING_H_
#define SPROUT_SERVICES_RECORD_RECORDING_H_

#include <atomic>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "common/app/service_context.h"
#include "common/app/stage_monitor.h"
#include "common/bus/receiver.h"
#include "common/core/frame.h"
#include "common/frames/sequence_gaps.h"
#include "services/record/event_queue.h"
#include "services/record/log_folder.h"
#include "services/record/recorder.h"

namespace sprout::record {

struct RecordingOptions {
  std::vector<std::string> channels;  ///< without prefix
  LogFolderOptions folder;
  std::optional<RingOptions> ring;
  std::optional<std::string> trigger_channel;  ///< without prefix; any message there
  std::optional<double> trigger_confidence;    ///< a mean confidence (0 to 1) below it
};

/// Records the running graph. One thread takes what comes and never waits for the disk; another one
/// writes. What comes while 512 MB wait to be written is dropped and counted as a bad message.
class Recording {
 public:
  /// @param monitor  is told what is lost; its status goes into the log.
  /// @throws ConfigError for a folder that cannot be used, BusError, see OpenLcm().
  Recording(const ServiceContext& context, RecordingOptions options, StageMonitor& monitor);

  ~Recording() { queue_.Close(); }
  Recording(const Recording&) = delete;
  Recording& operator=(const Recording&) = delete;

  /// Keeps what is in the ring.
  /// @param who  wants it, for people.
  void Trigger(const std::string& who);

  /// Puts our own status into the log; call once a second: it also shows that time passes.
  void PutStatus();

  /// Nothing can be written any more; the monitor was told why.
  bool has_failed() const { return failed_; }

  /// Bytes that wait to be written.
  size_t waiting_bytes() const { return queue_.bytes(); }

  /// Receives nothing any more, writes what waits, and ends the log. Call once.
  void Finish();

  /// Whether a recording without loss came of it; after Finish().
  bool IsWhole() const;

  /// What was written and lost, in one line; after Finish().
  std::string Summary() const;

 private:
  RecordedEvent MakeEvent(std::string channel, std::span<const uint8_t> bytes) const;
  RecordedEvent StatusEvent() const;
  bool IsOwn(std::string_view channel, std::span<const uint8_t> bytes) const;
  bool IsRecorded(std::string_view channel) const;
  void Receive(std::string_view channel, std::span<const uint8_t> bytes);
  void Drop(std::string_view channel);
  void CountFrame(Part part, std::span<const uint8_t> bytes);
  void WriteAll();
  void Handle(QueuedEvent item);
  void PullTrigger(RecordedEvent::Clock::time_point now, const std::string& who);
  void LookAtConfidence(const RecordedEvent& event);
  void Fail(const std::string& reason);

  RecordingOptions options_;
  std::string prefix_;
  StageMonitor& monitor_;
  std::optional<Part> counted_part_;   // whose messages stand for frames
  std::map<Part, SequenceGaps> gaps_;  // of the receiving thread
  std::atomic<int64_t> dropped_ = 0;   // did not fit into the queue
  int64_t triggers_ = 0;               // of the writing thread, as all below
  int64_t unwritten_ = 0;              // waited when writing failed
  std::atomic<bool> failed_ = false;
  EventQueue queue_;
  LogFolder folder_;
  Recorder recorder_;
  std::jthread writing_;
  std::optional<Receiver> receiver_;
};

}  // namespace sprout::record

#endif  // SPROUT_SERVICES_RECORD_RECORDING_H_
