#pragma once

#include <string>
#include <vector>

#include "services/tools/evaluate/evaluate.h"

namespace sprout::evaluate {

/// A table for people: Markdown, with columns aligned so that a terminal shows them well, too.
/// @param rows  of equal length; the first one is the head. The first column stands left, all
/// others
///              right.
std::string MarkdownTable(const std::vector<std::vector<std::string>>& rows);

/// Metrics and times of every method on one scene, and one line about refinement.
/// @param is_wide  with all figures, up to 20 columns; else those that fit a terminal.
std::string SceneTable(const SceneResult& scene, bool is_wide = false);

/// Each cell (nonocc, error <= 1 px) beside the paper's figure and the difference, in points;
/// scenes and methods that are not in the paper are left out.
/// @returns nothing when none is left.
std::string PaperTable(std::vector<SceneResult> scenes);

/// Settings and results of a run.
struct RunResult {
  std::string preset;  ///< names of the configuration files, joined by '+'
  std::string tof;     ///< --tof
  std::vector<SceneResult> scenes;
};

// Both depend on the run's input only, except for the times, which are under "ms" and in columns
// that end in _ms. Shares are per cent; an undefined value (the mean error of an empty map) is null
// or an empty field. See README.md for the layout.

std::string ToJson(const RunResult& run);
std::string ToCsv(const RunResult& run);

}  // namespace sprout::evaluate
