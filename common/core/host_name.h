#pragma once

#include <unistd.h>

#include <array>
#include <string>

namespace sprout {

/// Host name of this machine; empty if unknown.
inline std::string HostName() {
  std::array<char, 256> name{};
  gethostname(name.data(), name.size() - 1);
  return name.data();
}

}  // namespace sprout
