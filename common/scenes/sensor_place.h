#ifndef SPROUT_COMMON_SCENES_SENSOR_PLACE_H_
#define SPROUT_COMMON_SCENES_SENSOR_PLACE_H_

namespace sprout::scenes {

/// Simulated range sensors look at the middle of what both colour cameras see at this disparity, a
/// share of the image width: the middle of what stereo scenes have.
inline constexpr double kAimDisparityPerWidth = 0.08;

/// How far they are over the line between the colour cameras, half way between them, m.
inline constexpr double kAboveM = 0.02;

}  // namespace sprout::scenes

#endif  // SPROUT_COMMON_SCENES_SENSOR_PLACE_H_
