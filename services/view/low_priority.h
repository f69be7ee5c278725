#ifndef SPROUT_SERVICES_VIEW_LOW_PRIORITY_H_
#define SPROUT_SERVICES_VIEW_LOW_PRIORITY_H_

namespace sprout::view {

/// Lowers the priority of the calling thread: viewing must not slow down the graph.
void LowerPriority();

}  // namespace sprout::view

#endif  // SPROUT_SERVICES_VIEW_LOW_PRIORITY_H_
