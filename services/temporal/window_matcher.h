#pragma once

#include <cstdint>

#include "services/temporal/view.h"

namespace sprout::temporal {

/// Positions are counted in parts of a pixel.
inline constexpr int kPositionBits = 7;
inline constexpr int kPositionParts = 1 << kPositionBits;

/// A place in an image, in parts of a pixel.
struct Place {
  int32_t u = 0;
  int32_t v = 0;
};

/// Looks for the window around `place` of one image in another one, beginning at `found`: steps of
/// Gauss and Newton on the squared differences of grey values, each window brought to one mean and
/// contrast.
/// @returns whether a place was found: both windows stay inside, and there is texture.
bool MatchWindow(const View<uint8_t>& before, Place place, const View<uint8_t>& after,
                 Place& found);

}  // namespace sprout::temporal
