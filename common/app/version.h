#ifndef SPROUT_COMMON_APP_VERSION_H_
#define SPROUT_COMMON_APP_VERSION_H_

#include <string>

namespace sprout {

/// Version of the programs, "0.1.0 (1a2b3c4)".
std::string Version();

}  // namespace sprout

#endif  // SPROUT_COMMON_APP_VERSION_H_
