#pragma once

#include <string>
#include <vector>

#include "services/tools/evaluate/evaluate.h"

namespace sprout::evaluate {

/// What the confidences are worth, as a picture in SVG: a row for each method that has one. First,
/// the reliability diagram, if it claims probabilities: the share of errors > 1 px over the share
/// that was claimed, of ten groups of pixels from the surest to the least sure; on the dashed
/// diagonal both are equal. Then the sparsification curve: bad 1 of the best per cent of the
/// pixels; dashed: if the wrong pixels came last. Thin lines: a scene each; thick: their mean.
/// @param scenes  all of the same methods.
/// @returns an empty text when no method has a confidence. O(scenes).
std::string ConfidenceSvg(const std::vector<SceneResult>& scenes);

}  // namespace sprout::evaluate
