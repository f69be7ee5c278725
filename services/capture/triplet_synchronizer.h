#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <limits>
#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include "common/core/tof_image.h"

namespace sprout::capture {

/// Position of a camera in a rig.
enum class RigPlace { kLeft, kRight, kTof };
inline constexpr std::array kRigPlaces = {RigPlace::kLeft, RigPlace::kRight, RigPlace::kTof};

/// One camera's image and when it was taken.
struct TimedImage {
  int64_t utime = 0;  ///< middle of the exposure, host's time, µs
  cv::Mat image;      ///< of the left or right camera
  TofImage tof;       ///< of the ToF camera
};

/// Images that were taken together.
struct Triplet {
  TimedImage left;
  TimedImage right;
  std::optional<TimedImage> tof;
  /// Middle of the exposures of left and right, µs.
  int64_t utime() const { return left.utime + (right.utime - left.utime) / 2; }
  /// Between the earliest and the latest of them, ms.
  double spread_ms() const;
};

struct TripletConfig {
  /// Images whose times are at most this far apart belong together, µs; > 0.
  int64_t max_spread_us = 5000;
  bool has_tof = true;  ///< whether the rig has a ToF camera
  /// Longest wait for an image after its exposure, µs. After that a pair is output without a ToF
  /// image, and images of one camera without a partner count as unpaired.
  int64_t max_wait_us = 500'000;
};

/// What became of the ToF camera's images.
struct TofJoins {
  int64_t pairs = 0;   ///< of left and right
  int64_t came = 0;    ///< ToF images
  int64_t joined = 0;  ///< of them: to a pair
  int64_t pairs_since_join = 0;
  int64_t longest_gap = 0;  ///< most pairs between two that joined: a sensor may be slow
  /// Time from the middle of a pair to the nearest ToF image that did not join, µs; positive if the
  /// image is later.
  std::optional<int64_t> nearest_us = {};
};

/// Why ToF images do not join: none came, or they are too far from all pairs in time.
/// @param sensor  its name, for the text.
/// @returns one line when so many pairs in a row have none that something must be wrong: 10, 100,
///          1000 ... (`at_end`: less than two thirds of those that could joined); else nothing.
std::string JoinTrouble(const TofJoins& joins, const TripletConfig& config,
                        const std::string& sensor, bool at_end);

/// Joins images by the time of their exposure. Images of one camera come in the order of their
/// exposure; those of different cameras in any order. Deterministic; reads no clock.
class TripletSynchronizer {
 public:
  explicit TripletSynchronizer(const TripletConfig& config) : config_(config) {}

  /// Takes an image. If it is older than its camera's newest image (the clock jumped), all waiting
  /// images of that camera count as unpaired.
  void Push(RigPlace place, TimedImage image);

  /// Whether to wait for images of the ToF camera: false when it is lost.
  void SetTofIsThere(bool is_there) { tof_is_there_ = is_there; }

  /// Drops waiting images of a camera that was started again, since its times may differ.
  void Drop(RigPlace place);

  /// The next triplet, if it is final. Call again, there may be more.
  /// @param now_utime  host's time, µs.
  std::optional<Triplet> Next(int64_t now_utime);

  /// Images without partners so far. A ToF image between two pairs counts, too.
  int64_t unpaired(RigPlace place) const { return unpaired_[Index(place)]; }

  const TofJoins& tof_joins() const { return joins_; }
  const TripletConfig& config() const { return config_; }

 private:
  using Queue = std::deque<TimedImage>;

  // Times between the newest images of a camera: two, of which one may be long by a lost image.
  struct Pace {
    static constexpr int64_t kUnknown = std::numeric_limits<int64_t>::max() / 8;
    int64_t newest = kUnknown;
    std::array<int64_t, 2> steps = {kUnknown, kUnknown};
  };

  static size_t Index(RigPlace place) { return static_cast<size_t>(place); }
  Queue& QueueOf(RigPlace place) { return queues_[Index(place)]; }
  void DropFront(RigPlace place);
  void DropOverdue(int64_t now_utime);
  bool IsAlone(RigPlace place, int64_t utime) const;
  bool CloserMayCome(RigPlace place, int64_t utime, int64_t now_utime) const;
  bool FindPair(int64_t now_utime);
  enum class Search { kFound, kNone, kWait };
  Search FindTof(int64_t now_utime);
  void NoteDistance(int64_t tof_utime, int64_t pair_utime);
  void NoteOverdue();

  TripletConfig config_;
  bool tof_is_there_ = true;
  bool tof_is_silent_ = false;
  std::array<Queue, kRigPlaces.size()> queues_;
  std::array<Pace, kRigPlaces.size()> paces_;
  std::array<int64_t, kRigPlaces.size()> unpaired_{};
  TofJoins joins_;
  std::optional<int64_t> overdue_tof_utime_;  // of the newest ToF image that came before all pairs
};

}  // namespace sprout::capture
