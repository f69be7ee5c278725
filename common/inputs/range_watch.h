#pragma once

#include <cstdint>
#include <string>

#include "common/core/seed.h"
#include "common/core/tof_image.h"

namespace sprout::inputs {

/// Counts what becomes of the range images of a recording or a live graph, and says when a step
/// that gave something gives nothing, or never did: they come, have returns, hit the picture, and
/// become seeds.
class RangeWatch {
 public:
  /// @param seeds, left_seeds  of a frame, with the counts of the rules.
  /// @returns a line with all counts when a step gives nothing that gave something in an earlier
  ///          frame, or when points are in the picture and none becomes a seed; once, until that
  ///          changes; else nothing. What is so from the start CheckInputs() says. Of images that
  ///          do not come it is said after more than 10 frames and twice the longest pause so far:
  ///          many sensors are slower than the cameras.
  std::string Add(const TofImage& tof, const SeedSet& seeds, const SeedSet& left_seeds);

 private:
  enum class Step { kNone, kCame, kReturns, kHits, kSeeds };  // that gave nothing

  int64_t frames_ = 0;
  int64_t without_ = 0;        // frames since the last range image
  int64_t longest_pause_ = 0;  // of these between two range images
  int64_t came_ = 0;
  int64_t returned_ = 0;
  int64_t hit_ = 0;
  int64_t became_seeds_ = 0;
  Step last_ = Step::kNone;
};

}  // namespace sprout::inputs
