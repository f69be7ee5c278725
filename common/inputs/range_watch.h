#pragma once

#include <array>
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
  ///          changes; else nothing. CheckInputs() says what is so from the start. Missing images
  ///          are reported after more than 10 frames and twice the longest pause so far, since many
  ///          sensors are slower than the cameras.
  std::string Add(const TofImage& tof, const SeedSet& seeds, const SeedSet& left_seeds);

 private:
  // The steps from a ToF image to seeds, in order; kNone: none of them is silent.
  enum class Step { kCame, kReturns, kHits, kSeeds, kNone };

  int64_t Gave(Step step) const { return gave_[static_cast<size_t>(step)]; }
  std::string TextOf(Step silent, const SeedSet& seeds) const;

  int64_t frames_ = 0;
  std::array<int64_t, 4> gave_{};  // frames in which the step gave something
  int64_t without_ = 0;            // frames since the last range image
  int64_t longest_pause_ = 0;      // of these between two range images
  Step last_ = Step::kNone;        // that gave nothing
};

}  // namespace sprout::inputs
