#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace sprout::inputs {

/// What the numbers of a range image may be.
enum class Reading : int8_t {
  kDepth,
  kInverse,     ///< disparities, or one over depths
  kAlongRay,    ///< distances from the sensor, which are larger beside its axis
  kOtherBytes,  ///< mm of 16 bits, the low byte taken for the high one
  kWithFlags,   ///< mm in the lower 13 bits, the confidence above them (Android's DEPTH16)
};

/// The depth of a number that is read so, of kInverse in an unknown unit.
/// @param ray  of its pixel; z is 1.
double DepthOf(Reading reading, float number, const Eigen::Vector3d& ray);

/// What to say of numbers that have to be read so; {:.0f} stands for the share in % that agrees
/// then.
const char* TextOf(Reading reading);

}  // namespace sprout::inputs
