#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/config/frame_range.h"
#include "common/core/frame.h"
#include "common/logfile/log_reader.h"

namespace sprout {

/// Called with each message that cannot be used, and why.
using Refuse = std::function<void(const LogEvent& event, const std::string& why)>;

/// Which messages of a log are read.
struct FrameChoice {
  std::string prefix = {};       ///< before the channels of the graph
  PartSet parts = AllParts();    ///< others are skipped, except calibrations
  FrameRange frames = {};        ///< others are skipped
  size_t look_back = kLookBack;  ///< see FrameIndex

  static constexpr size_t kLookBack = 64;
  static constexpr size_t kWholeLog = std::numeric_limits<size_t>::max();
};

/// Positions of the messages of a frame in its log.
struct IndexedFrame {
  FrameId id;
  std::array<int64_t, kPartCount> offsets;  ///< of events, by number of the part; −1: none

  explicit IndexedFrame(FrameId of) : id(std::move(of)) { offsets.fill(-1); }
  int64_t& offset(Part part) { return offsets[static_cast<size_t>(part)]; }
  int64_t offset(Part part) const { return offsets[static_cast<size_t>(part)]; }
  bool Has(Part part) const { return offset(part) >= 0; }
};

/// A part of a frame that came again.
struct RepeatedPart {
  FrameId id;
  Part part;
  int64_t earlier, later;  ///< offsets of the two events
};

/// Index of the frames of a log, so that they can be read in any order: some 300 bytes a frame,
/// whatever the size of its messages. All programs that inspect logs use its rules:
///
/// * Messages with the same FrameId are one frame, in any order. It need not be complete: callers
/// check for missing parts.
/// * Late: when `look_back` other frames have begun after it, the frame is over, and a message with
/// its id begins another frame. A recording of a log that was played twice has each id twice.
/// * Repeated: of several messages of a part the newest counts; see repeats().
/// * The calibration comes separately, once a second: it belongs to every frame with its rig_id,
/// before and after it. Of several with the same rig_id the first counts; one with other numbers is
/// refused.
/// * A message without a valid frame id, of another type than its channel's, or an unreadable
/// calibration is refused, reported, and belongs to no frame. Only the header of other messages is
/// read here; FetchParts() reports those that cannot be decoded.
/// * Damage of the log is skipped and reported by LogReader.
///
/// Stages, and programs that read logs like stages (capture's log feed, calibrate), take only
/// complete frames and count the others: that is the rule of FrameJoiner, see WholeFrames. Not
/// thread-safe.
class FrameIndex {
 public:
  explicit FrameIndex(FrameChoice choice) : choice_(std::move(choice)) {}

  /// Takes an event of the log. O(log frames).
  void Add(const LogEvent& event, const Refuse& refuse = {});

  /// Takes a message whose part and id are known; not for kRig.
  void Add(Part part, const FrameId& id, int64_t offset);

  /// Takes an event only if it is a calibration.
  void AddRig(const LogEvent& event, const Refuse& refuse = {});

  /// The frames in the order of their first messages, without their calibrations.
  const std::vector<IndexedFrame>& frames() const { return frames_; }

  /// Each message of a part that the frame had already, in the order of the log.
  const std::vector<RepeatedPart>& repeats() const { return repeats_; }

  /// A frame with its calibration, when that is known. @pre number < frames().size().
  IndexedFrame At(size_t number) const;

  /// The newest frame with this id; an empty rig_id matches any. Null when there is none.
  const IndexedFrame* Find(const FrameId& id) const;

  /// "there are channels as B_SPROUT_LEFT, see --channel-prefix" when the log has channels of the
  /// graph with another prefix only; else empty.
  std::string OtherPrefixText() const;

 private:
  struct IndexedRig {
    int64_t offset;
    std::string digest;  // of its numbers
  };

  FrameChoice choice_;
  std::vector<IndexedFrame> frames_;
  std::vector<RepeatedPart> repeats_;
  std::map<FrameId, size_t> newest_;        // number of the newest frame with an id
  std::map<std::string, IndexedRig> rigs_;  // by rig_id
  bool has_channel_ = false;
  std::string other_channel_;  // of another prefix
};

}  // namespace sprout
