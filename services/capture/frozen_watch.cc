#include "services/capture/frozen_watch.h"

#include <fmt/core.h>

#include <functional>
#include <string_view>

namespace sprout::capture {
namespace {

// Of an image that differs from the last one, only every so many rows are looked at.
constexpr int kSparseRows = 8;

size_t HashOf(const cv::Mat& image, int step) {
  size_t hash = 0;
  for (int y = 0; y < image.rows; y += step) {
    const std::string_view row(image.ptr<char>(y),
                               static_cast<size_t>(image.cols) * image.elemSize());
    hash = hash * 31 + std::hash<std::string_view>()(row);
  }
  return hash;
}

}  // namespace

void FrozenWatch::Add(const scenes::CapturedFrame& frame) {
  Look(cameras_[0], frame.left);
  Look(cameras_[1], frame.right);
  Look(cameras_[2], frame.tof.depth_m);
}

void FrozenWatch::Look(Camera& camera, const cv::Mat& image) {
  if (image.empty()) return;
  const size_t sparse = HashOf(image, kSparseRows);
  std::optional<size_t> whole;
  if (camera.same > 0 && sparse == camera.sparse) whole = HashOf(image, 1);
  const bool is_same = whole && (!camera.whole || camera.whole == whole);
  camera.same = is_same ? camera.same + 1 : 1;
  camera.sparse = sparse;
  camera.whole = whole;
  if (camera.same == kImages) {
    camera.warning = fmt::format(
        "the {} camera gives the same image again and again, bit for bit: it hangs, or sees "
        "nothing",
        camera.name);
    monitor_.Warn(camera.warning);
    monitor_.HoldWarning(camera.warning);
  } else if (camera.same == 1 && !camera.warning.empty()) {
    monitor_.Resolve(camera.warning);
    camera.warning.clear();
  }
}

}  // namespace sprout::capture
