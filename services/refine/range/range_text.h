#ifndef SPROUT_SERVICES_REFINE_RANGE_RANGE_TEXT_H_
#define SPROUT_SERVICES_REFINE_RANGE_RANGE_TEXT_H_

#include <optional>
#include <string>

#include "services/refine/range/range_bias.h"

namespace sprout::refine {

/// One line for people: how far the sensor is off, in mm with its standard deviation, at the
/// nearest and the farthest depth and where it is most, and what share of the points was moved.
/// @returns empty for a sensor that is right; nothing when the images do not show it, or contradict
///          too many points.
std::optional<std::string> RangeErrorText(const RangeError& error);

}  // namespace sprout::refine

#endif  // SPROUT_SERVICES_REFINE_RANGE_RANGE_TEXT_H_
