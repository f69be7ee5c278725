#ifndef SPROUT_COMMON_APP_LIMITS_TEXT_H_
#define SPROUT_COMMON_APP_LIMITS_TEXT_H_

#include <exception>
#include <string>

namespace sprout {

/// For a failure due to a limit of this process, for which the system only says "Resource
/// temporarily unavailable" or "std::bad_alloc": names the limit, as ": ..." to append to the
/// message. Otherwise empty.
std::string ReachedLimitText(const std::exception& failure);

}  // namespace sprout

#endif  // SPROUT_COMMON_APP_LIMITS_TEXT_H_
