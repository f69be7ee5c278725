#include "services/capture/frozen_watch.h"

#include <fmt/core.h>

namespace sprout::capture {

void FrozenWatch::Add(const scenes::CapturedFrame& frame) {
  Look(cameras_[0], frame.left);
  Look(cameras_[1], frame.right);
  Look(cameras_[2], frame.tof.depth_m);
}

void FrozenWatch::Look(Camera& camera, const cv::Mat& image) {
  if (image.empty()) return;
  const int same = camera.count.Add(image);
  if (same == kImages) {
    camera.warning = fmt::format(
        "the {} camera gives the same image again and again, bit for bit: it hangs, or sees "
        "nothing",
        camera.name);
    monitor_.Warn(camera.warning);
    monitor_.HoldWarning(camera.warning);
  } else if (same == 1 && !camera.warning.empty()) {
    monitor_.Resolve(camera.warning);
    camera.warning.clear();
  }
}

}  // namespace sprout::capture
