#ifndef SPROUT_COMMON_SCENES_SOLID_TEXTURE_H_
#define SPROUT_COMMON_SCENES_SOLID_TEXTURE_H_

#include <cstdint>

#include "common/scenes/vec3.h"

namespace sprout::scenes {

/// A hash of a number, the same on every machine; hashes of neighbours are unrelated.
uint64_t Scramble(uint64_t value);

/// Value noise in space: a point has the same value for every camera.
///
/// Three octaves, chosen by the size of a pixel's footprint: features of about 2 to 12 px, fine
/// enough for stereo, but not so fine that they alias. Octaves fade in and out as the distance
/// changes.
///
/// @param point       m, in the coordinates of the object; |coordinate / pixel_m| < 1e9.
/// @param pixel_m     width of a pixel's footprint at the point, m, > 0.
/// @param key         different keys give different noise.
/// @returns 0 to 1, mean about 0.5.
/// O(1), no libm function that rounds differently between machines.
double SolidNoise(const Vec3& point, double pixel_m, uint64_t key);

}  // namespace sprout::scenes

#endif  // SPROUT_COMMON_SCENES_SOLID_TEXTURE_H_
