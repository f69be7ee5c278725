#ifndef SPROUT_COMMON_CORE_SEED_H_
#define SPROUT_COMMON_CORE_SEED_H_

#include <cstdint>
#include <span>
#include <vector>

namespace sprout {

/// A correspondence (u, u', v) of the rectified pair, px; pixel centres lie at whole numbers.
struct Seed {
  float u = 0;        ///< column in the left image
  float v = 0;        ///< row in both images
  float u_right = 0;  ///< column in the right image (u' in the paper)

  float disparity() const { return u - u_right; }  ///< d = u − u', px

  bool operator==(const Seed&) const = default;
};

/// The seeds of one frame, and what happened to the ToF points on the way:
/// raw = outside + dark + loose + background + hidden + seeds.size().
struct SeedSet {
  std::vector<Seed> seeds;
  int32_t raw = 0;         ///< ToF points with a return
  int32_t outside = 0;     ///< behind the cameras, or their window leaves an image
  int32_t dark = 0;        ///< on a very dark region, or with a weak ToF amplitude
  int32_t loose = 0;       ///< on no surface: flying pixels, outliers
  int32_t background = 0;  ///< beside a nearer seed
  int32_t hidden = 0;      ///< behind a nearer surface, from the left or the right camera

  bool operator==(const SeedSet&) const = default;
};

/// Both lists, the one behind the other.
/// @param both  is overwritten; its memory is used again.
inline void Join(std::span<const Seed> one, std::span<const Seed> other, std::vector<Seed>& both) {
  both.assign(one.begin(), one.end());
  both.insert(both.end(), other.begin(), other.end());
}

}  // namespace sprout

#endif  // SPROUT_COMMON_CORE_SEED_H_
