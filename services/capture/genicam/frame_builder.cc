#include "services/capture/genicam/frame_builder.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace sprout::capture {
namespace {

constexpr std::array kStereo = {RigPlace::kLeft, RigPlace::kRight};

// A stamp may be that of the end of an exposure of 100 ms, and a reading some ms off.
constexpr int64_t kEarliestUs = 120'000;
// ToF cameras compute for a while; a busy host reads late.
constexpr int64_t kLatestUs = 2'000'000;
constexpr int kMisfits = 5;

TripletConfig ConfigOf(const RigDescription& rig) {
  return {.max_spread_us = std::llround(rig.max_spread_ms() * 1e3), .has_tof = rig.has_tof()};
}

}  // namespace

const CameraDevice& DeviceOf(RigPlace place, const RigDescription& rig) {
  switch (place) {
    case RigPlace::kLeft:
      return rig.left();
    case RigPlace::kRight:
      return rig.right();
    case RigPlace::kTof:
      break;
  }
  return rig.tof();
}

std::string PlaceText(RigPlace place, const RigDescription& rig) {
  constexpr std::array kNames = {"left", "right", "ToF"};
  return fmt::format("{} camera (serial {})", kNames[static_cast<size_t>(place)],
                     DeviceOf(place, rig).serial());
}

FrameBuilder::FrameBuilder(const RigDescription& rig) : rig_(rig), synchronizer_(ConfigOf(rig)) {
  synchronizer_.SetTofIsThere(false);  // until it is opened
}

void FrameBuilder::Add(RigPlace place, CameraEvent event) {
  switch (event.kind) {
    case CameraEvent::Kind::kOpened:
      At(place).clock.Restart();
      At(place).is_read = false;
      At(place).is_distrusted = false;
      At(place).misfits = 0;
      synchronizer_.Drop(place);
      if (place == RigPlace::kTof) synchronizer_.SetTofIsThere(true);
      return;
    case CameraEvent::Kind::kGone:
      if (place == RigPlace::kTof) synchronizer_.SetTofIsThere(false);
      Complain(place, event.text);
      return;
    case CameraEvent::Kind::kClock:
      if (At(place).is_distrusted) return;
      if (!std::exchange(At(place).is_read, true)) At(place).clock.Restart();
      AddTime(place, event.clock.device_ns, event.clock.utime);
      return;
    case CameraEvent::Kind::kImage:
      AddImage(place, std::move(event.image));
      return;
  }
}

void FrameBuilder::AddImage(RigPlace place, DeviceImage image) {
  At(place).lost += image.lost;
  if (!image.trouble.empty()) Complain(place, image.trouble);
  if (image.image.empty() && image.tof.depth_m.empty()) return;
  ++At(place).images;
  const int64_t end_ns = image.device_ns + image.exposure_ns;
  if (At(place).is_read) {
    CheckReading(place, end_ns, image.arrived_utime);
  } else {
    AddTime(place, end_ns, image.arrived_utime);
  }
  // With PTP all devices have one clock, so one regression tells its time: no camera's delay then
  // parts it from the others.
  const bool is_shared = rig_.trigger() == RigDescription::PTP;
  const DeviceClock& clock = At(is_shared ? RigPlace::kLeft : place).clock;
  if (!clock.is_set()) return;  // right after a start
  synchronizer_.Push(place, {.utime = clock.HostUs(image.device_ns + image.exposure_ns / 2),
                             .image = std::move(image.image),
                             .tof = std::move(image.tof)});
}

void FrameBuilder::AddTime(RigPlace place, int64_t device_ns, int64_t utime) {
  const std::optional<std::string> jump = At(place).clock.Add(device_ns, utime);
  if (!jump) return;
  Complain(place, *jump);
  synchronizer_.Drop(place);
}

// Images arrive soon after their exposure. Otherwise the clock has jumped since it was read, or the
// clock that is read is not the one that stamps images.
void FrameBuilder::CheckReading(RigPlace place, int64_t end_ns, int64_t arrived_utime) {
  Place& camera = At(place);
  if (!camera.clock.is_set()) return;
  const int64_t delay_us = arrived_utime - camera.clock.HostUs(end_ns);
  if (delay_us >= -kEarliestUs && delay_us <= kLatestUs) {
    camera.misfits = 0;
    return;
  }
  ++camera.misfits;
  if (camera.misfits % kMisfits != 0) return;
  camera.clock.Restart();
  synchronizer_.Drop(place);
  if (camera.misfits == kMisfits) {
    Complain(place, "its clock contradicts its images; reading it again");
    return;
  }
  camera.is_distrusted = true;
  camera.is_read = false;
  Complain(place, "its clock contradicts its images; from now on times follow from their arrival");
}

void FrameBuilder::Complain(RigPlace place, const std::string& text) {
  constexpr size_t kMaxLength = 500;  // of the text of one frame
  const std::string trouble = PlaceText(place, rig_) + ": " + text;
  if (trouble_.size() > kMaxLength || trouble_.find(trouble) != std::string::npos) return;
  trouble_ += (trouble_.empty() ? "" : "; ") + trouble;
}

int64_t FrameBuilder::LostOf(RigPlace place) const {
  return places_[static_cast<size_t>(place)].lost + synchronizer_.unpaired(place);
}

int64_t FrameBuilder::LostSince(RigPlace place) const {
  return LostOf(place) - lost_before_[static_cast<size_t>(place)];
}

// Captures that are missing since the last frame. When one camera loses an image, that of the other
// one has no partner: both count the capture, so the larger count is taken.
int64_t FrameBuilder::Lost() const {
  int64_t lost = 0;
  for (const RigPlace place : kStereo) lost = std::max(lost, LostSince(place));
  // Until the first frame nothing counts as lost, since the cameras start one after the other.
  return has_frames_ ? lost : 0;
}

std::optional<scenes::CapturedFrame> FrameBuilder::Next(int64_t now_utime) {
  std::optional<Triplet> triplet = synchronizer_.Next(now_utime);
  if (!triplet) return std::nullopt;
  scenes::CapturedFrame frame;
  frame.utime = triplet->utime();
  frame.spread_ms = triplet->spread_ms();
  frame.left = std::move(triplet->left.image);
  frame.right = std::move(triplet->right.image);
  if (triplet->tof) frame.tof = std::move(triplet->tof->tof);
  frame.lost = Lost();
  frame.trouble = std::exchange(trouble_, "");
  told_.clear();
  if (frame.lost > 0 && frame.trouble.empty()) {
    frame.trouble = fmt::format(
        "images without a partner within max_spread_ms = {}: {} of the left camera, {} of the "
        "right one",
        rig_.max_spread_ms(), LostSince(RigPlace::kLeft), LostSince(RigPlace::kRight));
  }
  if (frame.trouble.empty()) {
    frame.trouble = JoinTrouble(synchronizer_.tof_joins(), synchronizer_.config(), "the ToF camera",
                                /*at_end=*/false);
  }
  for (const RigPlace place : kStereo) lost_before_[static_cast<size_t>(place)] = LostOf(place);
  for (Place& place : places_) place.images = 0;
  has_frames_ = true;
  return frame;
}

std::string FrameBuilder::NewTrouble() {
  if (trouble_ != told_) {
    told_ = trouble_;
    return trouble_;
  }
  const int64_t left = At(RigPlace::kLeft).images;
  const int64_t right = At(RigPlace::kRight).images;
  if (left == 0 || right == 0) return "";
  return fmt::format(
      "no two of the left camera's {} images and the right one's {} are within max_spread_ms = {}; "
      "trigger = {}",
      left, right, rig_.max_spread_ms(), RigDescription::Trigger_Name(rig_.trigger()));
}

}  // namespace sprout::capture
