#ifndef SPROUT_SERVICES_BATCH_HOST_NAME_H_
#define SPROUT_SERVICES_BATCH_HOST_NAME_H_

#include <unistd.h>

#include <string>

namespace sprout {

/// Of this machine; "?" when it has none.
inline std::string HostName() {
  char name[256] = "?";
  gethostname(name, sizeof name - 1);
  return name;
}

}  // namespace sprout

#endif  // SPROUT_SERVICES_BATCH_HOST_NAME_H_
