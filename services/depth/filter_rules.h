#ifndef SPROUT_SERVICES_DEPTH_FILTER_RULES_H_
#define SPROUT_SERVICES_DEPTH_FILTER_RULES_H_

#include <optional>
#include <string>

#include "common/config/config.h"
#include "services/depth/map_filter.h"

namespace sprout::depth {

/// What the configuration leaves out of maps.
/// @param base_from_left  of the rig file; nothing without one, and then there can be no box.
/// @throws ConfigError for what does not go together.
FilterRules FilterOf(const DepthConfig& config, const std::optional<Pose>& base_from_left);

/// Whether points outside a box of the robot's frame are left out.
bool HasBox(const DepthConfig& config);

/// @throws ConfigError unless low < high; names are those of DepthConfig.
void RequireOrder(const char* low_name, double low, const char* high_name, double high);

}  // namespace sprout::depth

#endif  // SPROUT_SERVICES_DEPTH_FILTER_RULES_H_
