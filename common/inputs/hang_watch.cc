#include "common/inputs/hang_watch.h"

#include <fmt/core.h>

namespace sprout::inputs {

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
