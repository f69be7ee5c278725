#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "common/bus/receiver.h"
#include "common/config/config.h"
#include "common/core/frame.h"
#include "common/core/stage_status.h"
#include "common/messages/codec.h"

namespace sprout {

/// Everything that a running graph says, kept by frame, so that nothing of two captures is mixed
/// when numbers start again, and so that every answer can be computed again.
class GraphRecord {
 public:
  using Clock = std::chrono::steady_clock;
  using Key = std::pair<int64_t, int64_t>;  ///< (utime, seq)

  /// What was heard of a frame.
  struct Heard {
    Frame frame;                           ///< newest of each part
    std::map<Part, Clock::time_point> at;  ///< first time that each part was heard
  };

  explicit GraphRecord(const std::string& url, const std::string& prefix = "");

  /// Waits for a condition on what was heard; false after `timeout`. Its members only in there
  /// and in Now().
  bool WaitUntil(const std::function<bool(GraphRecord&)>& condition,
                 std::chrono::milliseconds timeout = std::chrono::seconds(30));

  /// Looks at what was heard so far. @returns what `look` does.
  template <typename Look>
  auto Now(const Look& look) {
    const std::lock_guard lock(mutex_);
    return look(*this);
  }
  std::map<Key, Heard> FramesNow() {
    return Now([](GraphRecord& r) { return r.frames; });
  }
  size_t SentNow() {
    return Now([](GraphRecord& r) { return r.sent.size(); });
  }

  std::map<Key, Heard> frames;
  std::vector<Key> sent;                    ///< in the order in which a first part was heard
  std::map<int32_t, StageStatus> statuses;  ///< newest of each process

 private:
  void OnMessage(std::string_view channel, std::span<const uint8_t> bytes);
  void Add(Part part, DecodedPart decoded);

  std::mutex mutex_;
  std::condition_variable changed_;
  std::map<std::string, Rig> rigs_;  // by rig_id
  Receiver receiver_;                // last: stops before the rest is destroyed
};

/// How many answers were compared with what the same input gives in one process.
struct Comparison {
  int64_t maps = 0;         ///< disparity maps that were heard
  int64_t wrong = 0;        ///< of them, other bytes than those of a Pipeline on the frame's input
  int64_t unknown = 0;      ///< of them, without the whole input here: not compared
  std::string first_wrong;  ///< what is wrong with the first of them
};

/// Computes every frame that has a DISPARITY again: the map, its confidence and its depth must be
/// what Pipeline and DepthOf() make of the frame's own images, to the byte.
Comparison CompareWithPipeline(const std::map<GraphRecord::Key, GraphRecord::Heard>& frames,
                               const SproutConfig& config);

/// What is wrong with a comparison; empty when there are `least` maps or more, none of them wrong,
/// each of a frame that was sent whole.
std::string Objection(const Comparison& comparison, int64_t least);

/// Frames that a stage counts as lost on its way, for whatever reason.
int64_t CountedLost(const StageStatus& status);

/// Text about what became of the frames of a stage since the status `before`.
std::string AccountText(const StageStatus& status, const StageStatus& before = {});

/// Frames that a stage has accounted for: answered or lost.
inline int64_t AccountedFor(const StageStatus& status) {
  return status.frames_out + CountedLost(status);
}

}  // namespace sprout
