#ifndef SPROUT_SERVICES_TOOLS_EVALUATE_PAPER_FIGURES_H_
#define SPROUT_SERVICES_TOOLS_EVALUATE_PAPER_FIGURES_H_

#include <optional>
#include <string>

namespace sprout::evaluate {

/// What the paper reports for a method of this name on a scene of this name: per cent of
/// non-occluded pixels with an error ≤ 1 px, the ToF camera simulated by every 10th ground-truth
/// pixel. Nothing when the paper has no such figure.
std::optional<double> PaperPercent(const std::string& scene, const std::string& method);

}  // namespace sprout::evaluate

#endif  // SPROUT_SERVICES_TOOLS_EVALUATE_PAPER_FIGURES_H_
