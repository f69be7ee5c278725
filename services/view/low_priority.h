#ifndef SPROUT_SERVICES_VIEW_LOW_PRIORITY_H_
#define SPROUT_SERVICES_VIEW_LOW_PRIORITY_H_

namespace sprout::view {

/// Of the thread that calls: looking at the graph must not slow it down.
void LowerPriority();

}  // namespace sprout::view

#endif  // SPROUT_SERVICES_VIEW_LOW_PRIORITY_H_
