#include "common/app/low_priority.h"

#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "common/app/log.h"

namespace sprout {

void LowerPriority() {
  constexpr int kNice = 10;
  const auto thread = static_cast<id_t>(syscall(SYS_gettid));
  if (setpriority(PRIO_PROCESS, thread, kNice) != 0)
    LogLine(LogLevel::kDebug, "the priority stays as it is");
}

}  // namespace sprout
