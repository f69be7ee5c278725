#pragma once

#include <cstddef>
#include <cstdint>

namespace sprout::temporal {

/// Positions are counted in parts of a pixel.
inline constexpr int kPositionBits = 7;
inline constexpr int kPositionParts = 1 << kPositionBits;

/// A grey image as the kernel reads it.
struct GreyView {
  const uint8_t* pixels;
  ptrdiff_t stride;  // bytes from row to row
  int width, height;
};

/// A place in an image, in parts of a pixel.
struct Place {
  int32_t u = 0;
  int32_t v = 0;
};

/// Looks for the window around `place` of one image in another one, beginning at `found`: steps of
/// Gauss and Newton on the squared differences of grey values, each window brought to one mean and
/// contrast.
/// @returns whether a place was found: both windows stay inside, and there is texture.
bool MatchWindow(const GreyView& before, Place place, const GreyView& after, Place& found);

}  // namespace sprout::temporal
