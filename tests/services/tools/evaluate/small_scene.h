#pragma once

#include "services/tools/evaluate/scene.h"

namespace sprout::evaluate {

/// A made-up scene that every method gets through in milliseconds.
inline Scene SmallScene() { return LoadScene("synthetic:96x72", TofChoice("grid:4"), {}); }

}  // namespace sprout::evaluate
