#include "services/capture/genicam/device_clock.h"

#include <gmock/gmock.h>

#include <cmath>
#include <random>

namespace sprout::capture {
namespace {

constexpr int64_t kStartUs = 1'700'000'000'000'000;
constexpr int64_t kHourNs = 3'600'000'000'000;

// A device whose clock is an hour ahead and runs too fast, 10 images a second. Each arrives 3 to 5
// ms after its exposure, every 7th 100 ms later.
class DriftingDevice {
 public:
  explicit DriftingDevice(double drift_ppm) : drift_ppm_(drift_ppm) {}

  int64_t DeviceNs(int64_t host_us) const {
    const auto passed_us = static_cast<double>(host_us - kStartUs);
    return kHourNs + jump_ns_ + std::llround(passed_us * 1e3 * (1 + drift_ppm_ * 1e-6));
  }

  // The time of exposure of image `index`, µs; `clock` hears of its arrival.
  int64_t Expose(int64_t index, DeviceClock& clock) {
    const int64_t exposed_us = kStartUs + index * 100'000;
    const int64_t late_us = index % 7 == 3 ? 100'000 : 0;
    told_ = clock.Add(DeviceNs(exposed_us),
                      exposed_us + kDelayUs + static_cast<int64_t>(random_() % 2000) + late_us);
    if (told_) ++told_count_;
    return exposed_us;
  }

  void Jump(int64_t by_ns) { jump_ns_ += by_ns; }
  const std::optional<std::string>& told() const { return told_; }
  int told_count() const { return told_count_; }

  static constexpr int64_t kDelayUs = 3000;

 private:
  double drift_ppm_;
  int64_t jump_ns_ = 0;
  std::mt19937 random_{7};
  std::optional<std::string> told_;
  int told_count_ = 0;
};

TEST(DeviceClock, FindsAnHourOfOffsetAndAHundredPpmOfDrift) {
  for (const double drift_ppm : {100.0, -100.0, 0.0}) {
    DriftingDevice device(drift_ppm);
    DeviceClock clock;
    for (int64_t i = 0; i < 3000; ++i) {
      const int64_t exposed_us = device.Expose(i, clock);
      const int64_t error_us = clock.HostUs(device.DeviceNs(exposed_us)) - exposed_us;
      // The first images may have come late; without a slope the time drifts by 1 ms in 10 s.
      if (i >= 10) {
        EXPECT_NEAR(static_cast<double>(error_us), DriftingDevice::kDelayUs, 2100) << i;
      }
      if (i >= 600) {
        EXPECT_NEAR(static_cast<double>(error_us), DriftingDevice::kDelayUs, 500) << i;
      }
    }
    EXPECT_NEAR(clock.drift_ppm(), -drift_ppm, 5);
    EXPECT_EQ(device.told_count(), 0);
  }
}

TEST(DeviceClock, StartsAgainWhenTheClockJumps) {
  for (const int64_t jump_ns : {int64_t{500'000'000}, int64_t{-50'000'000}, kHourNs / 2}) {
    DriftingDevice device(20);
    DeviceClock clock;
    for (int64_t i = 0; i < 300; ++i) device.Expose(i, clock);
    device.Jump(jump_ns);
    int64_t exposed_us = 0;
    for (int64_t i = 300; i < 400; ++i) exposed_us = device.Expose(i, clock);
    EXPECT_EQ(device.told_count(), 1) << jump_ns;
    EXPECT_NEAR(static_cast<double>(clock.HostUs(device.DeviceNs(exposed_us)) - exposed_us),
                DriftingDevice::kDelayUs, 2100);
  }
}

TEST(DeviceClock, SaysByHowMuchItJumped) {
  DeviceClock clock;
  for (int64_t i = 0; i < 100; ++i) clock.Add(i * 100'000'000, kStartUs + i * 100'000);
  std::optional<std::string> told;
  for (int64_t i = 100; i < 200 && !told; ++i) {
    told = clock.Add(i * 100'000'000 + 250'000'000, kStartUs + i * 100'000);
  }
  EXPECT_EQ(told, "its clock jumped by +250.0 ms against the host's; started again with it");
}

TEST(DeviceClock, StartsAgainAtOnceWhenTheClockRunsBackwards) {
  DeviceClock clock;
  clock.Add(5'000'000'000, kStartUs);
  EXPECT_TRUE(clock.Add(1'000'000'000, kStartUs + 100'000));
  EXPECT_EQ(clock.HostUs(1'000'000'000), kStartUs + 100'000);
}

TEST(DeviceClock, BearsPacketsThatAHostHadToWaitFor) {
  DriftingDevice device(0);
  DeviceClock clock;
  for (int64_t i = 0; i < 100; ++i) device.Expose(i, clock);
  // Nothing is read for a second, at the end of which all its images arrive at once.
  const int64_t end_us = kStartUs + 112 * 100'000;
  for (int64_t i = 100; i < 112; ++i) {
    EXPECT_FALSE(clock.Add(device.DeviceNs(kStartUs + i * 100'000), end_us));
  }
  const int64_t exposed_us = device.Expose(112, clock);
  EXPECT_NEAR(static_cast<double>(clock.HostUs(device.DeviceNs(exposed_us)) - exposed_us),
              DriftingDevice::kDelayUs, 1000);
}

TEST(DeviceClock, KnowsATimeFromTheFirstPairOn) {
  DeviceClock clock;
  EXPECT_FALSE(clock.is_set());
  EXPECT_FALSE(clock.Add(77, kStartUs));
  EXPECT_TRUE(clock.is_set());
  EXPECT_EQ(clock.HostUs(1'000'077), kStartUs + 1000);
}

}  // namespace
}  // namespace sprout::capture
