#include "common/inputs/hang_watch.h"

#include <fmt/core.h>

#include <utility>

#include "common/core/image.h"

namespace sprout::inputs {
namespace {

constexpr int kNoise = 8;  // grey values by which a compressed still may change

// Whether an image repeats the one before, and shows something: what is black stays so.
bool Repeats(const cv::Mat& before, const cv::Mat& now) {
  if (before.size() != now.size() || before.type() != now.type()) return false;
  double darkest = 0;
  double brightest = 0;
  cv::minMaxLoc(ToGrey(now), &darkest, &brightest);
  return brightest - darkest > kNoise && cv::norm(before, now, cv::NORM_INF) == 0;
}

double ChangedPercent(const cv::Mat& before, const cv::Mat& now) {
  if (before.size() != now.size() || before.type() != now.type()) return 0;
  cv::Mat difference;
  cv::absdiff(before, now, difference);
  return 100.0 * cv::countNonZero(ToGrey(difference) > kNoise) / static_cast<double>(now.total());
}

}  // namespace

std::string RepeatWatch::Add(const cv::Mat& left, const cv::Mat& right) {
  constexpr double kMovedPercent = 10;
  const cv::Mat left_before = std::exchange(left_, left);
  const cv::Mat right_before = std::exchange(right_, right);
  const bool left_repeats = Repeats(left_before, left);
  if (left_repeats == Repeats(right_before, right)) return {};
  const double percent =
      left_repeats ? ChangedPercent(right_before, right) : ChangedPercent(left_before, left);
  if (percent < kMovedPercent) return {};
  return fmt::format(
      "the {} image is that of the pair before, to the last bit, while {:.0f} % of the {} one "
      "changed: they are of two moments",
      left_repeats ? "left" : "right", percent, left_repeats ? "right" : "left");
}

std::string HangWatch::Add(const Frame& frame) {
  constexpr int kImages = 10;
  constexpr std::array kNames = {"left", "right", "range"};
  if (frame.id.rig_id != rig_id_) images_ = {};
  rig_id_ = frame.id.rig_id;
  const cv::Mat ranges = frame.tof ? cv::Mat(frame.tof->depth_m) : cv::Mat();
  const std::array newest = {&frame.left, &frame.right, &ranges};
  for (size_t i = 0; i < newest.size(); ++i) {
    if (newest[i]->empty()) continue;
    Images& images = images_[i];
    const bool is_first = images.same == 0;
    images.same = images.count.Add(*newest[i]);
    images.changed |= images.same == 1 && !is_first;
  }
  const bool picture_changes = images_[0].same == 1 || images_[1].same == 1;
  std::string which;
  for (size_t i = 0; i < newest.size(); ++i) {
    const Images& images = images_[i];
    const bool is_due = !newest[i]->empty() && images.same % kImages == 0;
    if (!is_due || !(images.changed || picture_changes)) continue;
    which += fmt::format("{}{} {}", which.empty() ? "" : ", ", images.same, kNames[i]);
  }
  if (which.empty()) return which;
  return which +
         " images in a row are the same, to the last bit: what gives them hangs, or sees nothing "
         "(in a simulation without noise: nothing moves)";
}

}  // namespace sprout::inputs
