#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <vector>

namespace sprout::capture {

/// Converts a device's time stamps to the host's time. Model:
///
///   host = device + offset + drift · device + delay,   delay ≥ 0, now and then long
///
/// The delay is the travel time of a packet. The shortest delay of every 2 s is kept, for the
/// newest 60 s. The line through these is fitted by the Theil-Sen estimator (median of the slopes
/// of all pairs of points; median of the remainders), which tolerates almost a third of bad points.
/// The smallest delay itself cannot be distinguished from an offset: it remains in host times.
///
/// It reads no clock: the same pairs give the same times.
class DeviceClock {
 public:
  /// Adds a pair: an event of device time `device_ns` arrived at `host_us`. O(1), at most 30²/2
  /// slopes.
  /// @returns a message for people when the device's clock (or the host's) jumped: the fit then
  ///          started again.
  std::optional<std::string> Add(int64_t device_ns, int64_t host_us);

  /// Resets everything: the device was opened again.
  void Restart();

  /// Whether there is a pair yet.
  bool is_set() const { return !bins_.empty(); }

  /// Host time of a device's time, µs. @pre is_set().
  int64_t HostUs(int64_t device_ns) const;

  /// How much faster the host's clock runs than the device's, parts per million; 0 during the first
  /// 10 s.
  double drift_ppm() const { return slope_ * 1e6; }

 private:
  struct Pair {
    double device_us;  // since the first pair
    double delay_us;   // how far the host's time is ahead of the device's, since the first pair
  };
  struct Bin {
    int64_t index;
    Pair quickest;
  };

  Pair Relative(int64_t device_ns, int64_t host_us) const;
  double Residual(const Pair& pair) const;
  void Keep(const Pair& pair);
  void Fit();

  int64_t first_device_ns_ = 0;
  int64_t first_host_us_ = 0;
  int64_t newest_device_ns_ = 0;
  int64_t pair_count_ = 0;
  std::deque<Bin> bins_;
  double slope_ = 0;
  double offset_us_ = 0;
  // Pairs since the last one that fits, if they agree with each other. Many of them mean that a
  // clock jumped; late packets do not agree.
  struct Suspect {
    int64_t device_ns;
    int64_t host_us;
    double residual_us;
  };
  std::vector<Suspect> suspects_;
};

}  // namespace sprout::capture
