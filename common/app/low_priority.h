#ifndef SPROUT_COMMON_APP_LOW_PRIORITY_H_
#define SPROUT_COMMON_APP_LOW_PRIORITY_H_

namespace sprout {

/// Lowers the priority of the calling thread, and of those that it starts: what only looks at the
/// graph must not slow it down.
void LowerPriority();

}  // namespace sprout

#endif  // SPROUT_COMMON_APP_LOW_PRIORITY_H_
