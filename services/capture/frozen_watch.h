#pragma once

#include <array>
#include <string>

#include "common/app/stage_monitor.h"
#include "common/core/repeat_count.h"
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

  /// Takes the images of the next frame; empty ones are not looked at.
  void Add(const scenes::CapturedFrame& frame);

 private:
  struct Camera {
    const char* name;
    RepeatCount count = {};
    std::string warning = {};
  };

  void Look(Camera& camera, const cv::Mat& image);

  StageMonitor& monitor_;
  std::array<Camera, 3> cameras_ = {Camera{"left"}, Camera{"right"}, Camera{"range"}};
};

}  // namespace sprout::capture
