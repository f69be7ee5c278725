#ifndef SPROUT_SERVICES_CAPTURE_FROZEN_WATCH_H_
#define SPROUT_SERVICES_CAPTURE_FROZEN_WATCH_H_

#include <array>
#include <cstddef>
#include <optional>
#include <string>

#include "common/app/stage_monitor.h"
#include "common/scenes/frame_source.h"

namespace sprout::capture {

/// Warns of cameras that give the same image again and again, to the last bit, as one that hangs
/// does: noise makes each image of one that works another. The warning holds until the image
/// changes.
class FrozenWatch {
 public:
  /// Images in a row that are the same before it is said.
  static constexpr int kImages = 10;

  /// @param monitor  gets the warnings; must outlive this.
  explicit FrozenWatch(StageMonitor& monitor) : monitor_(monitor) {}

  /// Takes the images of the next frame; empty ones are not looked at. About 0.15 ms at
  /// 2 MP, and 1 ms while they are the same.
  void Add(const scenes::CapturedFrame& frame);

 private:
  struct Camera {
    const char* name;
    size_t sparse = 0;                 // of some rows of the newest image
    std::optional<size_t> whole = {};  // of all of them, where the image before had the same rows
    int same = 0;                      // images in a row that are the same
    std::string warning = {};
  };

  void Look(Camera& camera, const cv::Mat& image);

  StageMonitor& monitor_;
  std::array<Camera, 3> cameras_ = {Camera{"left"}, Camera{"right"}, Camera{"range"}};
};

}  // namespace sprout::capture

#endif  // SPROUT_SERVICES_CAPTURE_FROZEN_WATCH_H_
