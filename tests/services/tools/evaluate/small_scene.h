#ifndef SPROUT_TESTS_SERVICES_TOOLS_EVALUATE_SMALL_SCENE_H_
#define SPROUT_TESTS_SERVICES_TOOLS_EVALUATE_SMALL_SCENE_H_

#include "services/tools/evaluate/scene.h"

namespace sprout::evaluate {

/// A made-up scene that every method gets through in milliseconds.
inline Scene SmallScene() { return LoadScene("synthetic:96x72", TofChoice("grid:4"), {}); }

}  // namespace sprout::evaluate

#endif  // SPROUT_TESTS_SERVICES_TOOLS_EVALUATE_SMALL_SCENE_H_
