#pragma once

#include <string>
#include <string_view>

#include "common/config/config_error.h"

namespace sprout {

/// What to say of `what`, which needs a part that was left out of this build (CMake option
/// SPROUT_<part>): "WHAT: built without ROS 2 and MCAP; -DSPROUT_ROS2=ON needs cyclonedds-dev ...".
ConfigError LeftOut(const std::string& what, std::string_view part);

}  // namespace sprout
