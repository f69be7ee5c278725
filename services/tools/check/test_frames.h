#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/core/frame.h"
#include "services/tools/check/contract.h"

namespace sprout::check {

/// A frame to be sent, without utime and seq: it is sent as a new capture each time.
struct TestFrame {
  std::string name;  ///< "frame 3", "frame 3 without seeds": for findings
  std::string rig_id;
  std::map<Part, PartValue> parts = {};    ///< the stage's inputs
  std::optional<PartValue> recorded = {};  ///< the stage's answer, if the log has it

  const Rig& rig() const { return std::get<Rig>(parts.at(Part::kRig)); }
};

/// The frames of a log that have all inputs of a stage.
/// @throws LogError when the log cannot be read; ConfigError when it has no such frame.
std::vector<TestFrame> ReadTestFrames(const std::filesystem::path& log,
                                      const StageContract& contract);

/// Degenerate frames, made from a good one: no ToF return, too few seeds, seeds on a line, black
/// images, sizes that contradict each other.
std::vector<TestFrame> DegenerateFrames(const TestFrame& good);

/// A way to corrupt a valid message, such that every program must refuse it.
struct Corruption {
  std::string name;  ///< "width = -1"
  /// Takes bytes of EncodePart(), with maps as RAW_INT16.
  std::function<std::vector<uint8_t>(std::vector<uint8_t> good)> apply;
};

/// Ways to corrupt the message of a part: cut short, of another type, random bytes, counts and
/// sizes that do not fit, NaN and infinities. Always the same ones.
std::vector<Corruption> CorruptionsOf(Part part);

}  // namespace sprout::check
