#pragma once

#include <cstdint>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "common/core/frame.h"
#include "services/tools/check/test_frames.h"

namespace sprout {

/// What is sent to do harm.
struct HostileMessage {
  std::string way;      ///< in which it was made, "truncated"
  std::string channel;  ///< without prefix
  std::vector<uint8_t> bytes;
  bool bad = false;  ///< no program may take it for good; of others nobody knows
};

/// An endless random mix of hostile messages; the same one for the same seed.
class HostileMessages {
 public:
  /// @param good  a frame with all parts that grow gets and with a recorded answer.
  HostileMessages(const check::TestFrame& good, uint32_t seed);

  /// For the channels of the parts, all of them: usually one; more where a way takes a whole frame
  /// or repeats itself.
  std::vector<HostileMessage> Next();

  /// One for SPROUT_STATUS or SPROUT_DISPARITY, which capture listens to.
  HostileMessage NextForCapture();

  /// The messages of a good frame, each one to three times, in a random order.
  std::vector<HostileMessage> GoodFrame(int64_t seq);

 private:
  using Bytes = std::vector<uint8_t>;

  uint32_t Below(size_t end) { return static_cast<uint32_t>(random_() % end); }
  double Extreme();
  FrameId RandomId();
  Bytes Encode(const FrameId& id, Part part, const PartValue& value);
  Bytes Status();
  Bytes Damaged(Bytes bytes, std::string& way, bool& bad);
  PartValue Odd(Part part, cv::Size size);
  Rig OddRig(cv::Size size);
  HostileMessage Corrupted(Part part);
  HostileMessage OfAnotherSize(Part part);
  HostileMessage OnWrongChannel(Part part);
  std::vector<HostileMessage> OddFrame();

  check::TestFrame good_;
  std::map<Part, PartValue> values_;  // of all parts
  std::mt19937 random_;
};

}  // namespace sprout
