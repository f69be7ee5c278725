#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/core/frame.h"
#include "common/core/planar_scan.h"
#include "common/core/stage_status.h"

namespace sprout {

/// One part that a stage adds to a frame.
struct PartOutput {
  Part part;
  PartValue value;
};

/// A stage's result for a frame.
struct StageResult {
  std::vector<PartOutput> outputs;
  /// Why the frame has no (or an empty) result, or one that cannot be right since its input is
  /// wrong; empty when all is well. One line, shown in the status.
  std::string degenerate;
  /// The offset of the ToF camera's points, if the stage measured it in this frame.
  TofOffsetStatus tof_offset = {};
  /// What goes on and is no failure, one line for the status: how far the range sensor is off, as
  /// the images of this frame show it, or that depths are too far for a message; empty: all is
  /// well; nothing: not known, or not looked for.
  std::optional<std::string> finding = {};
  /// Whether no range point was believed, since the sensor cannot be right; `degenerate` says why.
  bool ranges_refused = false;
  /// A picture of the frame for people, 8UC3 (BGR), at most 16384 px a side; empty: none. It is not
  /// a part of the frame: no stage uses it.
  cv::Mat preview = {};
  /// What a laser scanner would measure; no part of the frame either.
  std::optional<PlanarScan> scan = {};
};

/// Makes a stage a service: which parts it needs and what it answers. Uses no network, log or
/// clock, so that it runs the same way live and replayed.
class StageAdapter {
 public:
  virtual ~StageAdapter() = default;

  /// Parts that Process() needs.
  virtual PartSet Inputs() const = 0;

  /// The part of Inputs() that a frame may lack: a frame waits for them only until the next frame
  /// has all others, and is answered without them then.
  virtual PartSet OptionalInputs() const { return {}; }

  /// Answers one frame that has all Inputs(), but maybe optional ones. Frames come one at a time,
  /// in any order of seq, and the same frame may come twice; the answer depends on the frame only.
  /// A stage with memory (temporal) answers by all frames since it was made, and says so; the
  /// newest one again gets the same answer again.
  virtual StageResult Process(const Frame& frame) = 0;

  /// Number of frames that a stage with memory should see before the first one whose answer is
  /// wanted.
  virtual int WarmUpFrames() const { return 0; }
};

/// Answers a frame and adds the answer to it.
/// @returns why the frame has no (or an empty) result; empty when all is well.
inline std::string AddAnswer(StageAdapter& adapter, Frame& frame) {
  StageResult result = adapter.Process(frame);
  for (PartOutput& output : result.outputs) SetPart(frame, output.part, std::move(output.value));
  return result.degenerate;
}

}  // namespace sprout
