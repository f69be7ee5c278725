#ifndef SPROUT_COMMON_CORE_HOST_NAME_H_
#define SPROUT_COMMON_CORE_HOST_NAME_H_

#include <unistd.h>

#include <array>
#include <string>

namespace sprout {

/// Of this machine; empty when the system does not tell.
inline std::string HostName() {
  std::array<char, 256> name{};
  gethostname(name.data(), name.size() - 1);
  return name.data();
}

}  // namespace sprout

#endif  // SPROUT_COMMON_CORE_HOST_NAME_H_
