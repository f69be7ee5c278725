#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "common/core/frame.h"
#include "services/tools/check/contract.h"
#include "services/tools/check/program_check.h"

namespace sprout::check {

/// The rules that are checked for a capture process.
inline constexpr Rule kCaptureRules[] = {
    Rule::kSends, Rule::kWhole,  Rule::kSameHeader, Rule::kRising, Rule::kCalibration,
    Rule::kForm,  Rule::kValues, Rule::kChannels,   Rule::kEnd,
};

/// Longest time without a SPROUT_RIG, which is due once a second.
inline constexpr std::chrono::milliseconds kMaxRigSilence{2500};

/// Receives what a capture process sends, and finds what the graph could not use. The messages of a
/// frame are joined by their number, so that differences in the rest of the header are found.
class CaptureListener {
 public:
  using Clock = std::chrono::steady_clock;

  /// @param found  gets the findings; must outlive the listener.
  explicit CaptureListener(Findings& found) : found_(found) {}

  /// Takes the next message on the bus, in order of arrival.
  void Take(const Heard& heard);

  /// Marks the end of the messages. Frames after the last complete one may be unfinished.
  void Finish(Clock::time_point now);

  /// Frames with LEFT, RIGHT and TOF.
  int whole_frames() const { return whole_frames_; }

  /// Channels with messages, "SPROUT_LEFT, SPROUT_RIG"; "nothing".
  std::string HeardChannels() const;

  /// What was sent, for people: lines with size, rate and times. Empty without a complete frame.
  std::string Figures() const;

 private:
  struct Frame {
    FrameId id;
    std::string first_channel;  // whose header the others are compared with
    Clock::time_point begun;
    std::map<Part, PartValue> values;  // until it is complete; only decodable ones
    PartSet heard;
    bool over = false;  // complete, or older than a complete one
  };

  struct Calibration {
    Rig rig;
    std::string digest;
  };

  void TakeImage(Part part, const Heard& heard);
  void TakeRig(const Heard& heard);
  void CheckRigValues(const Rig& rig);
  void CheckRigSilence(Clock::time_point now);
  void CheckUnitOfUtime();
  double time_s() const;   // from the first whole frame to the last
  double utime_s() const;  // the same by their utime
  Frame* FrameOf(Part part, const FrameId& id, Clock::time_point when);
  Frame& Begin(Part part, const FrameId& id, Clock::time_point when);
  void Complete(Frame& frame, Clock::time_point when);
  void CheckSizes(const Frame& frame);
  void CheckImages(const Frame& frame);
  void CheckTof(const Frame& frame);

  Findings& found_;
  std::set<std::string> channels_;
  std::map<int64_t, Frame> frames_;          // by seq
  std::optional<FrameId> newest_;            // of the frames
  std::map<std::string, Calibration> rigs_;  // by rig_id
  int rigs_heard_ = 0;
  std::optional<Clock::time_point> last_rig_;

  // What the figures need to know of complete frames.
  int whole_frames_ = 0;
  cv::Size size_;
  cv::Size tof_size_;
  std::vector<double> spreads_ms_;  // from the first to the last message
  std::vector<double> ages_s_;      // of the first message, by utime
  std::vector<double> tof_depths_m_;
  int64_t tof_pixels_ = 0;
  int64_t tof_returns_ = 0;
  Clock::time_point first_whole_;
  Clock::time_point last_whole_;
  int64_t first_utime_ = 0;
  int64_t last_utime_ = 0;
};

}  // namespace sprout::check
