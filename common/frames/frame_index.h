#ifndef SPROUT_COMMON_FRAMES_FRAME_INDEX_H_
#define SPROUT_COMMON_FRAMES_FRAME_INDEX_H_

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

/// Is told of each message that cannot be used, and why.
using Refuse = std::function<void(const LogEvent& event, const std::string& why)>;

/// Which messages of a log are looked at.
struct FrameChoice {
  std::string prefix = {};       ///< before the channels of the graph
  PartSet parts = AllParts();    ///< others are not looked at; calibrations always are
  FrameRange frames = {};        ///< others are not looked at
  size_t look_back = kLookBack;  ///< see FrameIndex

  static constexpr size_t kLookBack = 64;
  static constexpr size_t kWholeLog = std::numeric_limits<size_t>::max();
};

/// Where the messages of a frame stand in its log.
struct IndexedFrame {
  FrameId id;
  std::array<int64_t, kPartCount> offsets;  ///< of events, by number of the part; −1: not there

  explicit IndexedFrame(FrameId of) : id(std::move(of)) { offsets.fill(-1); }
  int64_t& offset(Part part) { return offsets[static_cast<size_t>(part)]; }
  int64_t offset(Part part) const { return offsets[static_cast<size_t>(part)]; }
  bool Has(Part part) const { return offset(part) >= 0; }
};

/// Where the frames of a log stand, so that they can be read in any order: some 300 bytes a frame,
/// whatever the size of its messages. Its rule is that of everybody who looks into logs and wants
/// to see what is there:
///
/// * Messages with the same whole FrameId are one frame, in whatever order they come. It need not
///   be whole: a part that is missing is not there, and whoever needs it counts that.
/// * Late: when `look_back` other frames have begun behind it, the frame is over, and what comes
///   with its name begins another one. A recording that was played twice has each name twice.
/// * Doubled: of a part that comes again the newest message counts.
/// * The calibration travels apart, once a second: it belongs to every frame with its rig_id,
///   before and behind it. Of those with one rig_id, which is a digest, the first counts.
/// * A message that names no frame, is not of its channel's type, or is a calibration that cannot
///   be read, is refused, which is told, and belongs to no frame. Of the other messages only the
///   header is read here; those that cannot be decoded are told when they are (FetchParts()).
/// * Damage of the log: as LogReader, which skips it and says where.
///
/// Stages, and what stands in for them (capture's log feed, calibrate), take whole frames only and
/// count the others: that is the rule of FrameJoiner, see WholeFrames. Not thread-safe.
class FrameIndex {
 public:
  explicit FrameIndex(FrameChoice choice) : choice_(std::move(choice)) {}

  /// Takes an event of the log. O(log frames).
  void Add(const LogEvent& event, const Refuse& refuse = {});

  /// Takes a message that is known already; not for kRig.
  void Add(Part part, const FrameId& id, int64_t offset);

  /// Looks at an event for its calibration only.
  void AddRig(const LogEvent& event, const Refuse& refuse = {});

  /// The frames in the order of their first messages, without their calibrations.
  const std::vector<IndexedFrame>& frames() const { return frames_; }

  /// A frame with its calibration, when that is known. @pre number < frames().size().
  IndexedFrame At(size_t number) const;

  /// The newest frame with this name, an empty rig_id standing for any; null when there is none.
  const IndexedFrame* Find(const FrameId& id) const;

  /// "there are channels as B_SPROUT_LEFT, see --channel-prefix" when the log has channels of the
  /// graph with another prefix only; else empty.
  std::string OtherPrefixText() const;

 private:
  FrameChoice choice_;
  std::vector<IndexedFrame> frames_;
  std::map<FrameId, size_t> newest_;     // number of the newest frame with a name
  std::map<std::string, int64_t> rigs_;  // offsets by rig_id
  bool has_channel_ = false;
  std::string other_channel_;  // of another prefix
};

}  // namespace sprout

#endif  // SPROUT_COMMON_FRAMES_FRAME_INDEX_H_
