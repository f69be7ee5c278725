#include "services/capture/genicam/genicam_source.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <set>
#include <thread>
#include <utility>
#include <vector>

#include "common/app/log.h"
#include "common/config/config.h"
#include "common/core/sleep.h"
#include "common/rig/rig_file.h"
#include "services/capture/genicam/frame_builder.h"
#include "services/capture/genicam/pixels.h"

namespace sprout::capture {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

// Images that wait to be formed into triplets, of one camera: what comes while nobody asks is old.
constexpr std::ptrdiff_t kMaxWaiting = 16;
// How often a pair is asked whether it has waited long enough for its ToF image.
constexpr milliseconds kPoll(10);
// After kSilence without a frame the reason is reported, and again after each kReminder.
constexpr milliseconds kSilence(2000);
constexpr milliseconds kReminder(10'000);
// How long before an exposure the cameras are told of it: much longer than a packet travels.
constexpr int64_t kLeadNs = 50'000'000;

// Events of all cameras, in the order of their coming. Thread-safe, and bounded: cameras are seldom
// opened or lost, and of the rest only the newest stays.
class Inbox {
 public:
  using Event = std::pair<RigPlace, CameraEvent>;

  void Push(RigPlace place, CameraEvent event) {
    const std::lock_guard lock(mutex_);
    MakeRoom(place, event);
    events_.emplace_back(place, std::move(event));
    changed_.notify_one();
  }

  // All that is there, after waiting for a moment if there is nothing.
  std::deque<Event> Take(const std::stop_token& stop) {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, stop, kPoll, [&] { return !events_.empty(); });
    return std::exchange(events_, {});
  }

 private:
  // Drops the oldest event of a camera and a kind, if there are too many. An image counts as lost
  // with the newest one.
  void MakeRoom(RigPlace place, CameraEvent& newest) {
    using Kind = CameraEvent::Kind;
    if (newest.kind != Kind::kImage && newest.kind != Kind::kClock) return;
    const auto is_alike = [&](const Event& event) {
      return event.first == place && event.second.kind == newest.kind;
    };
    if (std::ranges::count_if(events_, is_alike) < kMaxWaiting) return;
    const auto oldest = std::ranges::find_if(events_, is_alike);
    if (newest.kind == Kind::kImage) {
      const DeviceImage& image = oldest->second.image;
      const bool is_good = !image.image.empty() || !image.tof.depth_m.empty();
      newest.image.lost += image.lost + (is_good ? 1 : 0);
      newest.image.trouble = "images come faster than they are taken";
    }
    events_.erase(oldest);
  }

  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::deque<Event> events_;
};

class GenicamSource : public RawSource {
 public:
  GenicamSource(const RigDescription& rig, scenes::Waiting waiting)
      : rig_(rig), waiting_(std::move(waiting)), builder_(rig) {
    const std::optional<RawRig> calibration = CalibrationOf(rig);
    for (const RigPlace place : kRigPlaces) {
      const bool is_tof = place == RigPlace::kTof;
      if (is_tof && !rig.has_tof()) continue;
      DeviceSettings settings{.device = DeviceOf(place, rig),
                              .trigger = rig.trigger(),
                              .frame_rate_hz = rig.frame_rate_hz(),
                              .is_tof = is_tof,
                              .lens = std::nullopt};
      if (calibration && calibration->tof.width > 0) settings.lens = calibration->tof;
      cameras_[static_cast<size_t>(place)] = std::make_unique<Camera>(
          settings, [this, place](CameraEvent event) { TakeEvent(place, std::move(event)); });
    }
    if (rig.trigger() == RigDescription::SOFTWARE) StartTriggers();
    if (rig.trigger() == RigDescription::PTP) {
      triggers_.emplace_back([this](const std::stop_token& stop) { Schedule(stop); });
    }
  }

  // Stops all cameras at the same time, since one that does not answer takes seconds.
  ~GenicamSource() override {
    for (std::jthread& trigger : triggers_) trigger.request_stop();
    for (const auto& camera : cameras_) {
      if (camera) camera->RequestStop();
    }
  }
  GenicamSource(const GenicamSource&) = delete;
  GenicamSource& operator=(const GenicamSource&) = delete;

  bool is_live() const override { return true; }

  std::optional<scenes::CapturedFrame> Next(const std::stop_token& stop) override {
    Clock::time_point next_word = Clock::now() + kSilence;
    while (!stop.stop_requested()) {
      if (std::optional<scenes::CapturedFrame> frame = builder_.Next(g_get_real_time()))
        return frame;
      if (waiting_) waiting_("");
      for (auto& [place, event] : inbox_.Take(stop)) builder_.Add(place, std::move(event));
      if (Clock::now() < next_word) continue;
      next_word = Clock::now() + kReminder;
      // Otherwise trouble is reported with the next frame.
      if (const std::string trouble = builder_.NewTrouble(); !trouble.empty()) {
        TellWaiting(waiting_, "waiting for the cameras: " + trouble);
      }
    }
    return std::nullopt;
  }

 private:
  void TakeEvent(RigPlace place, CameraEvent event) {
    if (event.kind == CameraEvent::Kind::kOpened) {
      LogLine(LogLevel::kInfo, "{}: {}", PlaceText(place, rig_), event.text);
    }
    inbox_.Push(place, std::move(event));
  }

  void StartTriggers() {
    const Clock::time_point first = Clock::now();
    for (const auto& camera : cameras_) {
      if (!camera) continue;
      // A thread each: one that does not answer is waited for, which the others must not be.
      triggers_.emplace_back([this, first, camera = camera.get()](const std::stop_token& stop) {
        Trigger(*camera, first, stop);
      });
    }
  }

  // Triggers a camera at times that are the same for all cameras.
  void Trigger(Camera& camera, Clock::time_point first, const std::stop_token& stop) const {
    const Clock::duration period = Period();
    while (!stop.stop_requested()) {
      camera.Trigger();
      SleepUntil(first + ((Clock::now() - first) / period + 1) * period, stop);
    }
  }

  // Tells all cameras the times of the next exposures, in the clock that they share: whole
  // multiples of the period.
  void Schedule(const std::stop_token& stop) const {
    const int64_t period_ns = std::chrono::nanoseconds(Period()).count();
    int64_t newest_ns = 0;
    while (!stop.stop_requested()) {
      const auto clock = cameras_[static_cast<size_t>(RigPlace::kLeft)]->ReadClock();
      const int64_t begin_ns = clock ? clock->device_ns + kLeadNs : 0;
      if (newest_ns > begin_ns + 2 * period_ns) newest_ns = 0;  // the clock was set back
      for (int64_t time_ns = (begin_ns / period_ns + 1) * period_ns;
           clock && time_ns <= begin_ns + 2 * period_ns; time_ns += period_ns) {
        if (time_ns <= newest_ns) continue;
        newest_ns = time_ns;
        for (const auto& camera : cameras_) {
          if (camera) camera->TriggerAt(time_ns);
        }
      }
      SleepFor(Period(), stop);
    }
  }

  Clock::duration Period() const {
    return std::chrono::duration_cast<Clock::duration>(
        std::chrono::duration<double>(1 / rig_.frame_rate_hz()));
  }

  RigDescription rig_;
  scenes::Waiting waiting_;
  FrameBuilder builder_;
  Inbox inbox_;
  std::array<std::unique_ptr<Camera>, kRigPlaces.size()> cameras_;
  std::vector<std::jthread> triggers_;  // last: they use the cameras
};

void RequireDevice(RigPlace place, const RigDescription& rig, const std::string& path,
                   std::set<std::string>& serials) {
  constexpr std::array kFields = {"left", "right", "tof"};
  const std::string field = path + ": " + kFields[static_cast<size_t>(place)];
  const CameraDevice& device = DeviceOf(place, rig);
  if (device.serial().empty()) {
    throw ConfigError(field + ".serial is missing; sprout-capture --list shows the cameras");
  }
  if (!serials.insert(device.serial()).second) {
    throw ConfigError(field + ".serial = " + device.serial() + " is that of another camera, too");
  }
  if (device.pixel_format().empty()) return;
  const auto format = PixelFormatNamed(device.pixel_format());
  const bool is_tof = place == RigPlace::kTof;
  if (format && (is_tof ? IsTofFormat(*format) : IsStereoFormat(*format))) return;
  throw ConfigError(field + ".pixel_format = " + device.pixel_format() +
                    "; allowed: " + (is_tof ? TofFormatNames() : StereoFormatNames()));
}

}  // namespace

std::unique_ptr<RawSource> OpenGenicam(const RigDescription& rig, const std::string& path,
                                       scenes::Waiting waiting) {
  RequireInRange(rig, path);
  std::set<std::string> serials;
  for (const RigPlace place : kRigPlaces) {
    if (place == RigPlace::kTof && !rig.has_tof()) continue;
    RequireDevice(place, rig, path, serials);
  }
  return std::make_unique<GenicamSource>(rig, std::move(waiting));
}

}  // namespace sprout::capture
