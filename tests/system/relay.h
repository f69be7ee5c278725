#ifndef SPROUT_TESTS_SYSTEM_RELAY_H_
#define SPROUT_TESTS_SYSTEM_RELAY_H_

#include <atomic>
#include <cstdint>
#include <random>
#include <thread>

namespace sprout {

/// What a bad network does to datagrams: the share, 0 to 1, of them that it ...
struct NetworkFaults {
  double lost = 0;
  double doubled = 0;    ///< delivers twice
  double reordered = 0;  ///< delivers after one to four of those that follow
};

/// A seeded bad network between two LCM ports of this host: passes what is sent to the group on one
/// port on to the other port, datagram by datagram, each sender's from a socket of its own, as LCM
/// tells senders apart. One direction only.
class Relay {
 public:
  static constexpr uint16_t kFrom = 7677;
  static constexpr uint16_t kTo = 7687;

  explicit Relay(uint32_t seed);
  ~Relay();
  Relay(const Relay&) = delete;
  Relay& operator=(const Relay&) = delete;

  /// From now on; none to begin with. Thread-safe.
  void Set(const NetworkFaults& faults);

  int64_t datagrams() const { return datagrams_; }  ///< that came
  int64_t lost() const { return lost_; }

 private:
  void Run(const std::stop_token& stop);

  std::mt19937 random_;
  std::atomic<double> lost_share_ = 0;
  std::atomic<double> doubled_share_ = 0;
  std::atomic<double> reordered_share_ = 0;
  std::atomic<int64_t> datagrams_ = 0;
  std::atomic<int64_t> lost_ = 0;
  int socket_;
  std::jthread thread_;  // last: stops before the rest is destroyed
};

}  // namespace sprout

#endif  // SPROUT_TESTS_SYSTEM_RELAY_H_
