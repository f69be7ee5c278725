#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>

namespace sprout {

/// Counts how often a camera gives the same image, to the last bit, as one that hangs does: noise
/// makes each image of one that works another.
class RepeatCount {
 public:
  /// @param image  not empty. About 0.08 ms for a pair of 2 MP, and 1 ms while they are the same.
  /// @returns images in a row that are the same, with this one.
  int Add(const cv::Mat& image);

 private:
  uint64_t sparse_ = 0;            // of some rows of the newest image
  std::optional<uint64_t> whole_;  // of all of them, where the image before had the same rows
  int same_ = 0;
};

}  // namespace sprout
