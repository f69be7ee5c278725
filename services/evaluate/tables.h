#ifndef SPROUT_SERVICES_EVALUATE_TABLES_H_
#define SPROUT_SERVICES_EVALUATE_TABLES_H_

#include <string>
#include <vector>

#include "services/evaluate/evaluate.h"

namespace sprout {

// Tables for people: Markdown, with columns aligned so that a terminal shows them well, too.

/// Metrics and times of every method on one scene, and one line about refinement.
std::string SceneTable(const SceneResult& scene);

/// Each cell (nonocc, error <= 1 px) beside the paper's figure and the difference, in points.
/// @returns nothing when the paper has no figure for any of the results.
std::string PaperTable(const std::vector<SceneResult>& scenes);

}  // namespace sprout

#endif  // SPROUT_SERVICES_EVALUATE_TABLES_H_
