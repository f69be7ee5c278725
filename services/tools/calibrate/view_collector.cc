#include "services/tools/calibrate/view_collector.h"

#include <algorithm>
#include <utility>

#include "common/core/image.h"
#include "services/tools/calibrate/rig_model.h"

namespace sprout::calibrate {
namespace {

// Least move of a new view, as a share of the image's width: 1 cm at 1 m for a lens of 53°. Nearer
// views tell little more.
constexpr double kNewShift = 0.01;

// Fastest move of a board that counts as still, as a share of the image's width a second. When
// exposures are 5 ms apart (rig.proto, max_spread_ms), corners move by 0.2 px of 2000 meanwhile.
constexpr double kStillShiftPerS = 0.02;

// Two triplets that are further apart than this say nothing about motion.
constexpr int64_t kMotionUs = 500'000;

// Mean distance of the corners that both have, px; nothing when there are few.
std::optional<double> MeanShift(const BoardCorners& a, const BoardCorners& b) {
  double sum = 0;
  int shared = 0;
  for (size_t i = 0, j = 0; i < a.ids.size() && j < b.ids.size();) {
    if (a.ids[i] < b.ids[j]) {
      ++i;
    } else if (b.ids[j] < a.ids[i]) {
      ++j;
    } else {
      sum += cv::norm(a.pixels[i++] - b.pixels[j++]);
      ++shared;
    }
  }
  if (shared < kMinCorners) return std::nullopt;
  return sum / shared;
}

}  // namespace

void ViewCollector::Add(const RigImages& images, std::optional<int64_t> utime) {
  ++counts_.images;
  const std::array<cv::Size, kCameraCount> sizes = {images.left.size(), images.right.size(),
                                                    images.tof.depth_m.size()};
  if (!FitsTheViews(sizes)) {
    ++counts_.other_size;
    return;
  }
  Pair pair{.left = FindBoard(board_, ToGrey(images.left)),
            .right = FindBoard(board_, ToGrey(images.right))};
  const bool moves = Moves(pair, utime, sizes[kLeft].width);
  if (std::max(pair.left.size(), pair.right.size()) < kMinCorners) {
    ++counts_.no_board;
    if (strange_.size() < kMaxStrange) strange_.push_back(ToGrey(images.left).clone());
    if (std::max(pair.left.markers, pair.right.markers) >= kMinCorners) ++counts_.foreign;
  } else if (moves) {
    ++counts_.moving;
  } else if (IsSimilar(pair)) {
    ++counts_.similar;
  } else if (std::ssize(views_) == kMaxViews) {
    ++counts_.too_many;
  } else {
    if (views_.empty()) sizes_ = sizes;
    // A ToF camera may be silent for a while.
    if (sizes_[kTof].empty()) sizes_[kTof] = sizes[kTof];
    views_.push_back({.corners = {std::move(pair.left), std::move(pair.right),
                                  FindBoardInAmplitude(board_, images.tof.amplitude)},
                      .tof = {.depth_m = images.tof.depth_m.clone(),
                              .amplitude = images.tof.amplitude.clone()}});
    int corners = 0;
    for (const BoardCorners& of_camera : views_.back().corners) corners += of_camera.size();
    if (corners <= best_corners_) return;
    best_corners_ = corners;
    best_images_ = {
        .left = images.left.clone(), .right = images.right.clone(), .tof = views_.back().tof};
  }
}

bool ViewCollector::FitsTheViews(const std::array<cv::Size, kCameraCount>& sizes) const {
  if (sizes[kLeft] != sizes[kRight]) return false;
  if (views_.empty()) return true;
  const bool has_both_tof = !sizes[kTof].empty() && !sizes_[kTof].empty();
  return sizes[kLeft] == sizes_[kLeft] && (!has_both_tof || sizes[kTof] == sizes_[kTof]);
}

bool ViewCollector::Moves(const Pair& pair, std::optional<int64_t> utime, int width) {
  if (!utime) return false;
  const std::optional<Timed> before = std::exchange(newest_, Timed{*utime, pair});
  if (!before || *utime - before->utime > kMotionUs || *utime <= before->utime) return false;
  const std::optional<double> shift_px = Shift(pair, before->pair);
  const double seconds = static_cast<double>(*utime - before->utime) / 1e6;
  return !shift_px || *shift_px > kStillShiftPerS * seconds * width;
}

bool ViewCollector::IsSimilar(const Pair& pair) const {
  return std::ranges::any_of(views_, [&](const BoardView& view) {
    const auto shift_px = Shift(pair, {view.corners[kLeft], view.corners[kRight]});
    return shift_px && *shift_px < kNewShift * sizes_[kLeft].width;
  });
}

std::optional<double> ViewCollector::Shift(const Pair& a, const Pair& b) {
  const std::optional<double> left = MeanShift(a.left, b.left);
  return left ? left : MeanShift(a.right, b.right);
}

}  // namespace sprout::calibrate
