#pragma once

#include <array>
#include <opencv2/core.hpp>
#include <string>

#include "common/core/frame.h"
#include "common/core/repeat_count.h"

namespace sprout::inputs {

/// Says which of the left, right and range images of a recording or a live graph stay the same, to
/// the last bit, as those of a sensor that hangs do. Of stills and simulations no picture ever
/// changes, so an image counts when it changed before under this calibration, or when a picture
/// changes beside it.
class HangWatch {
 public:
  /// An empty image is not looked at. About 0.1 ms for a pair of 2 MP, 1 ms while it stays the
  /// same.
  /// @returns a line at every tenth image in a row that is the same; else nothing.
  std::string Add(const Frame& frame);

 private:
  struct Images {
    RepeatCount count;
    int same = 0;          // in a row, with the newest one
    bool changed = false;  // ever
  };

  std::array<Images, 3> images_;  // left, right, range
  std::string rig_id_;
};

/// Says which image of a pair is that of the pair before, to the last bit, while the other view
/// moved: such a pair is of two moments. A compressed still repeats itself, too, but moves little.
class RepeatWatch {
 public:
  /// Keeps the images; their pixels must not change. @returns a line, or nothing.
  std::string Add(const cv::Mat& left, const cv::Mat& right);

 private:
  cv::Mat left_, right_;
};

}  // namespace sprout::inputs
