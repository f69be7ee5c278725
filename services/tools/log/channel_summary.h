#ifndef SPROUT_SERVICES_TOOLS_LOG_CHANNEL_SUMMARY_H_
#define SPROUT_SERVICES_TOOLS_LOG_CHANNEL_SUMMARY_H_

#include <cstdint>
#include <string>

#include "common/logfile/log_reader.h"
#include "services/tools/log/sequence.h"

namespace sprout::log {

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

}  // namespace sprout::log

#endif  // SPROUT_SERVICES_TOOLS_LOG_CHANNEL_SUMMARY_H_
