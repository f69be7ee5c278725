#include "services/capture/genicam/camera.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "common/core/sleep.h"

namespace sprout::capture {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr milliseconds kFirstPause(500);
constexpr milliseconds kLongestPause(8000);
// How soon a stop or a lost camera is noticed.
constexpr int64_t kPopTimeoutUs = 100'000;
// How often a camera is asked for its clock and its time of exposure.
constexpr milliseconds kAskPeriod(500);
// Time that some cameras need before their first image.
constexpr milliseconds kFirstImage(3000);

// How long a camera that works may send nothing.
Clock::duration LongestSilence(const DeviceSettings& settings) {
  // Nobody knows when the next pulse comes, or how long clocks need until they agree.
  if (settings.trigger == RigDescription::LINE || settings.trigger == RigDescription::PTP)
    return std::chrono::hours(24 * 365);
  const std::chrono::duration<double> periods(5 / settings.frame_rate_hz);
  return kFirstImage + std::chrono::duration_cast<Clock::duration>(periods);
}

}  // namespace

Camera::Camera(const DeviceSettings& settings, std::function<void(CameraEvent)> tell)
    : settings_(settings),
      tell_(std::move(tell)),
      thread_([this](const std::stop_token& stop) { Run(stop); }) {}

void Camera::Trigger() {
  const std::lock_guard lock(mutex_);
  if (device_) device_->Trigger();
}

void Camera::TriggerAt(int64_t device_ns) {
  const std::lock_guard lock(mutex_);
  if (device_) device_->TriggerAt(device_ns);
}

std::optional<ClockReading> Camera::ReadClock() {
  const std::lock_guard lock(mutex_);
  return device_ ? device_->ReadClock() : std::nullopt;
}

void Camera::Run(const std::stop_token& stop) {
  milliseconds pause = kFirstPause;
  std::string told;
  while (!stop.stop_requested()) {
    Result<std::unique_ptr<Device>> device = Device::Open(settings_);
    if (device) {
      tell_({.kind = CameraEvent::Kind::kOpened, .text = (*device)->text()});
      {
        const std::lock_guard lock(mutex_);
        device_ = std::move(*device);
      }
      const std::string reason = Read(stop);
      if (!stop.stop_requested()) {
        tell_({.kind = CameraEvent::Kind::kGone, .text = reason});
      }
      std::unique_lock lock(mutex_);
      const std::unique_ptr<Device> closed = std::move(device_);
      lock.unlock();
      told.clear();
      pause = kFirstPause;
      continue;
    }
    if (device.error().text != told) {
      told = device.error().text;
      tell_({.kind = CameraEvent::Kind::kGone, .text = told});
    }
    SleepFor(pause, stop);
    pause = std::min(2 * pause, kLongestPause);
  }
}

// Reads images until the camera is lost or a stop is asked for. Returns why it is lost.
std::string Camera::Read(const std::stop_token& stop) {
  // Only this thread changes device_, so reading it needs no lock.
  const Clock::duration silence = LongestSilence(settings_);
  Clock::time_point next_question = Clock::now();
  Clock::time_point newest = Clock::now();
  while (!stop.stop_requested()) {
    if (device_->is_lost()) return "does not answer any more";
    if (Clock::now() > newest + silence) {
      device_->GiveUp();
      return "sends nothing any more";
    }
    if (Clock::now() >= next_question) {
      Ask();
      next_question = Clock::now() + kAskPeriod;
    }
    if (std::optional<DeviceImage> image = device_->Next(kPopTimeoutUs)) {
      newest = Clock::now();
      tell_({.kind = CameraEvent::Kind::kImage, .text = "", .image = std::move(*image)});
    }
  }
  return "";
}

void Camera::Ask() {
  std::unique_lock lock(mutex_);
  device_->ReadExposure();
  const std::optional<ClockReading> clock = device_->ReadClock();
  lock.unlock();
  if (clock) tell_({.kind = CameraEvent::Kind::kClock, .text = "", .clock = *clock});
}

}  // namespace sprout::capture
