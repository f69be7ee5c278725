#pragma once

#include <cstdint>
#include <deque>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/core/frame.h"
#include "common/frames/frame_index.h"
#include "common/logfile/log_reader.h"
#include "services/tools/batch/frame_table.h"

namespace sprout::batch {

/// Finds the parts of frames in logs, in any order; the parts of one frame may be in several logs.
class FrameLookup {
 public:
  explicit FrameLookup(std::string prefix) : prefix_(std::move(prefix)) {}

  /// Adds these parts of a log. Reads all of it, in constant memory but for the positions of the
  /// messages. @throws LogError.
  void Add(const std::filesystem::path& log, const PartSet& parts = AllParts());

  /// Frames that have a part, in the order of the logs.
  std::vector<FrameId> FramesWith(Part part) const;

  /// Byte in the first log that has it where the part of a frame begins.
  std::optional<int64_t> PlaceOf(const FrameId& id, Part part) const;

  /// The parts of a frame that exist and can be decoded; if several logs have a part, it is taken
  /// from the last. An empty rig_id matches any.
  Frame Get(const FrameId& id, const PartSet& parts);

 private:
  struct Log {
    Log(const std::filesystem::path& path, const FrameChoice& choice)
        : fetcher(path), index(choice) {}

    EventFetcher fetcher;
    FrameIndex index;
  };

  std::string prefix_;
  std::deque<Log> logs_;
};

/// Columns behind kFrameColumns in the tables of MeasureFrames() and CompareFrames().
std::vector<std::string> MeasureColumns();
std::vector<std::string> ComparisonColumns();

/// The parts that QualityOf() looks at.
const PartSet& MeasuredParts();

/// A row for each answered frame with the figures of QualityOf(), of the fused map where that is
/// the answer.
/// @param frames  has the input, and the answers of all stages.
/// @param answer  the part that the last stage always answers.
Table MeasureFrames(FrameLookup& frames, Part answer);

/// A row for each frame that A or B answered: changed, moved, mean_change_px, max_change_px,
/// appeared, vanished.
/// @param map  the part to compare: kDisparity or kFused.
Table CompareFrames(FrameLookup& a, FrameLookup& b, Part map);

}  // namespace sprout::batch
