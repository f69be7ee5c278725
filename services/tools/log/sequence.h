#ifndef SPROUT_SERVICES_TOOLS_LOG_SEQUENCE_H_
#define SPROUT_SERVICES_TOOLS_LOG_SEQUENCE_H_

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/core/frame_id.h"

namespace sprout::log {

/// Follows the frame numbers on one channel.
class Sequence {
 public:
  /// Frames first to last.
  struct Gap {
    int64_t first = 0;
    int64_t last = 0;
  };

  void Add(const FrameId& id);

  std::optional<int64_t> first() const { return first_; }  ///< number of the first frame
  std::optional<int64_t> last() const;                     ///< number of the newest frame
  int64_t missing() const { return missing_; }             ///< missing frame numbers
  int64_t repeated() const { return repeated_; }           ///< repeated frames
  int64_t restarts() const { return restarts_; }           ///< of capture, with smaller numbers

  /// The first few gaps as text: "7, 12-15"; "..." means others.
  std::string GapText() const;

 private:
  std::optional<int64_t> first_;
  std::optional<FrameId> newest_;
  std::deque<FrameId> recent_;
  std::vector<Gap> gaps_;  // the first few
  int64_t gap_count_ = 0;
  int64_t missing_ = 0;
  int64_t repeated_ = 0;
  int64_t restarts_ = 0;
};

}  // namespace sprout::log

#endif  // SPROUT_SERVICES_TOOLS_LOG_SEQUENCE_H_
