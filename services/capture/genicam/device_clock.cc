#include "services/capture/genicam/device_clock.h"

#include <fmt/core.h>

#include <algorithm>
#include <cassert>
#include <cmath>

#include "common/core/quantile.h"

namespace sprout::capture {
namespace {

// A quartz drifts by less than 100 ppm: 0.2 ms in a bin, far below what delays vary by.
constexpr double kBinUs = 2e6;
constexpr int64_t kBins = 30;
// Over less than this, the delays' jitter (some 0.1 ms) makes more of a slope than drift does.
constexpr double kMinSpanUs = 10e6;
// A larger difference is a jump of the clock. More than delays vary by on an idle host, less than
// the time between two frames.
constexpr double kJumpUs = 20e3;
// Long enough (1 s at 10 Hz) that a busy host has worked off what waited.
constexpr size_t kSuspects = 10;
// The first packets may all have waited: an earlier one corrects the delay, and is no jump.
constexpr int64_t kSettled = 10;

std::string JumpText(double jump_us) {
  return fmt::format("its clock jumped by {:+.1f} ms against the host's; started again with it",
                     jump_us * 1e-3);
}

}  // namespace

void DeviceClock::Restart() { *this = DeviceClock(); }

DeviceClock::Pair DeviceClock::Relative(int64_t device_ns, int64_t host_us) const {
  const double device_us = static_cast<double>(device_ns - first_device_ns_) * 1e-3;
  return {device_us, static_cast<double>(host_us - first_host_us_) - device_us};
}

double DeviceClock::Residual(const Pair& pair) const {
  return pair.delay_us - offset_us_ - slope_ * pair.device_us;
}

std::optional<std::string> DeviceClock::Add(int64_t device_ns, int64_t host_us) {
  if (bins_.empty()) {
    first_device_ns_ = device_ns;
    first_host_us_ = host_us;
  }
  const Pair pair = Relative(device_ns, host_us);
  const double residual = bins_.empty() ? 0 : Residual(pair);
  if (!bins_.empty() && device_ns < newest_device_ns_) {  // no clock runs backwards
    Restart();
    Add(device_ns, host_us);
    return JumpText(-residual);
  }
  newest_device_ns_ = device_ns;
  ++pair_count_;
  if (std::abs(residual) <= kJumpUs || (residual < 0 && pair_count_ <= kSettled)) {
    suspects_.clear();
    Keep(pair);
    return std::nullopt;
  }
  if (!suspects_.empty()) {
    const double difference = residual - suspects_.front().residual_us;
    if (difference > kJumpUs) return std::nullopt;  // a packet that is late besides
    if (difference < -kJumpUs) suspects_.clear();   // the suspects before were only late packets
  }
  suspects_.push_back({device_ns, host_us, residual});
  if (suspects_.size() < kSuspects) return std::nullopt;
  const std::vector<Suspect> agreed = std::move(suspects_);
  Restart();
  for (const Suspect& suspect : agreed) Add(suspect.device_ns, suspect.host_us);
  return JumpText(-residual);
}

void DeviceClock::Keep(const Pair& pair) {
  const auto index = static_cast<int64_t>(std::floor(pair.device_us / kBinUs));
  if (bins_.empty() || index != bins_.back().index) {
    bins_.push_back({index, pair});
  } else if (Residual(pair) < Residual(bins_.back().quickest)) {
    bins_.back().quickest = pair;
  } else {
    return;  // the line does not change
  }
  while (bins_.front().index + kBins <= index) bins_.pop_front();
  Fit();
}

void DeviceClock::Fit() {
  const size_t count = bins_.size();
  slope_ = 0;
  if (bins_.back().quickest.device_us - bins_.front().quickest.device_us < kMinSpanUs) {
    // The newest two, as without a slope the older ones tell of another offset.
    offset_us_ = bins_.back().quickest.delay_us;
    if (count > 1) offset_us_ = std::min(offset_us_, bins_[count - 2].quickest.delay_us);
    return;
  }
  std::vector<double> values;
  for (size_t i = 0; i < count; ++i) {
    for (size_t k = i + 1; k < count; ++k) {
      const Pair& a = bins_[i].quickest;
      const Pair& b = bins_[k].quickest;
      values.push_back((b.delay_us - a.delay_us) / (b.device_us - a.device_us));
    }
  }
  slope_ = Median(values);
  values.clear();
  for (const Bin& bin : bins_) {
    values.push_back(bin.quickest.delay_us - slope_ * bin.quickest.device_us);
  }
  offset_us_ = Median(values);
}

int64_t DeviceClock::HostUs(int64_t device_ns) const {
  assert(is_set());
  const double device_us = static_cast<double>(device_ns - first_device_ns_) * 1e-3;
  return first_host_us_ + std::llround(device_us + offset_us_ + slope_ * device_us);
}

}  // namespace sprout::capture
