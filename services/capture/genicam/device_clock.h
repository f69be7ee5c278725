#ifndef SPROUT_SERVICES_CAPTURE_GENICAM_DEVICE_CLOCK_H_
#define SPROUT_SERVICES_CAPTURE_GENICAM_DEVICE_CLOCK_H_

#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <vector>

namespace sprout::capture {

/// The host's time of what a device stamps with its own clock. Model:
///
///   host = device + offset + drift · device + delay,   delay ≥ 0, now and then long
///
/// The delay is what a packet needs until it is here. The shortest delay of every 2 s is kept, for
/// the newest 60 s; the line through these is fitted by Theil and Sen's estimator (median of the
/// slopes of all pairs of points; median of what remains), which a third of bad points does not
/// move. The smallest delay itself cannot be told from an offset: it stays in host times.
///
/// No clock inside: the same pairs give the same times.
class DeviceClock {
 public:
  /// Takes in that something of device time `device_ns` was here at `host_us`. O(1), at most 30²/2
  /// slopes.
  /// @returns what to tell people when the device's clock (or the host's) jumped: the regression
  ///          then started again.
  std::optional<std::string> Add(int64_t device_ns, int64_t host_us);

  /// Forgets everything: the device was opened anew.
  void Restart();

  /// Whether there is a pair yet.
  bool is_set() const { return !bins_.empty(); }

  /// Host time of a device's time, µs. @pre is_set().
  int64_t HostUs(int64_t device_ns) const;

  /// How much faster the host's clock runs than the device's, parts per million; 0 until 10 s are
  /// known.
  double drift_ppm() const { return slope_ * 1e6; }

 private:
  struct Pair {
    double device_us;  // since the first pair
    double delay_us;   // what the host's time is ahead of the device's, since the first pair
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
  // Pairs since the last one that fits, which agree with each other: another time, if they are
  // many. Packets that are late agree on nothing.
  struct Suspect {
    int64_t device_ns;
    int64_t host_us;
    double residual_us;
  };
  std::vector<Suspect> suspects_;
};

}  // namespace sprout::capture

#endif  // SPROUT_SERVICES_CAPTURE_GENICAM_DEVICE_CLOCK_H_
