#pragma once

#include <string>

namespace sprout {

/// Version of the programs, "0.1.0 (1a2b3c4)".
std::string Version();

}  // namespace sprout
