#ifndef SPROUT_COMMON_APP_LIMITS_TEXT_H_
#define SPROUT_COMMON_APP_LIMITS_TEXT_H_

#include <exception>
#include <string>

namespace sprout {

/// For a failure that comes of a limit of this process, of which the system says no more than
/// "Resource temporarily unavailable" or "std::bad_alloc": which limit it is, to be put behind
/// that, ": ..."; else an empty text.
std::string ReachedLimitText(const std::exception& failure);

}  // namespace sprout

#endif  // SPROUT_COMMON_APP_LIMITS_TEXT_H_
