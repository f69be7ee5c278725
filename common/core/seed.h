#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

namespace sprout {

/// How a seed was measured; the numbers are those of lcmtypes/seeds_t.lcm.
enum class SeedOrigin : int8_t {
  kTof = 0,     ///< a point of the ToF camera
  kStereo = 1,  ///< matched between the two images
};

/// A correspondence (u, u', v) of the rectified pair, px; pixel centres lie at whole numbers.
struct Seed {
  float u = 0;        ///< column in the left image
  float v = 0;        ///< row in both images
  float u_right = 0;  ///< column in the right image (u' in the paper)
  /// Standard deviation of the disparity, px; finite and > 0.
  float sigma_px = 0.05F;
  SeedOrigin origin = SeedOrigin::kTof;
  int16_t tof_u = -1;  ///< column in the ToF image; −1: not known, or origin is not ToF
  int16_t tof_v = -1;  ///< row in the ToF image; −1 when tof_u is

  float disparity() const { return u - u_right; }  ///< d = u − u', px

  bool operator==(const Seed&) const = default;
};

/// The seeds of one frame, and how many ToF points were dropped by which rule: raw = outside + dark
/// + loose + background + hidden + contradicted + CountTofSeeds(seeds).
struct SeedSet {
  std::vector<Seed> seeds;
  int32_t raw = 0;         ///< ToF points with a return
  int32_t outside = 0;     ///< behind the cameras, or their window leaves an image
  int32_t dark = 0;        ///< on a very dark region, or with a weak ToF amplitude
  int32_t loose = 0;       ///< isolated: flying pixels, outliers
  int32_t background = 0;  ///< beside a nearer seed
  int32_t hidden = 0;      ///< behind a nearer surface, from the left or the right camera
  /// ToF points that the images contradict, for instance beyond the camera's unambiguous range.
  int32_t contradicted = 0;

  bool operator==(const SeedSet&) const = default;
};

/// How many of the seeds are points of the ToF camera. O(n).
inline int32_t CountTofSeeds(std::span<const Seed> seeds) {
  return static_cast<int32_t>(std::count_if(seeds.begin(), seeds.end(), [](const Seed& seed) {
    return seed.origin == SeedOrigin::kTof;
  }));
}

/// The two lists, one after the other.
/// @param both  is overwritten; its memory is used again.
inline void Join(std::span<const Seed> one, std::span<const Seed> other, std::vector<Seed>& both) {
  both.assign(one.begin(), one.end());
  both.insert(both.end(), other.begin(), other.end());
}

}  // namespace sprout
