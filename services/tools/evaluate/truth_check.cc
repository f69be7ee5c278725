#include "services/tools/evaluate/truth_check.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "common/inputs/check_inputs.h"
#include "common/scenes/tof_grid.h"

namespace sprout::evaluate {
namespace {

// The share of a scan's points on pixels with a known truth that lie within 1 px of it.
double ShareOnTruth(const scenes::DatasetFrame& frame, const TofProjector& scanner) {
  constexpr size_t kMinKnown = 100;  // points that tell something
  const cv::Mat1f& truth = frame.truth.left;
  int behind = 0;
  size_t known = 0;
  size_t near = 0;
  for (const ProjectedPoint& point : scanner.Project(frame.tof, behind)) {
    const cv::Point pixel(cvRound(point.seed.u), cvRound(point.seed.v));
    if (!cv::Rect({0, 0}, truth.size()).contains(pixel)) continue;
    const float error = std::abs(point.seed.disparity() - truth(pixel));
    known += std::isfinite(error);
    near += error <= 1;
  }
  return known < kMinKnown ? 1 : static_cast<double>(near) / static_cast<double>(known);
}

}  // namespace

std::string WrongTruthText(const scenes::DatasetFrame& frame, const RectifiedPair& pair,
                           const TofProjector* scanner) {
  constexpr int kStepPx = 3;  // KITTI's truth has gaps between the beams
  constexpr double kMinShareOnTruth = 0.75;
  if (std::min(pair.width, pair.height) < kStepPx) return "";
  const Rig rig{.pair = pair, .tof = scenes::TofGridCamera(pair, kStepPx)};
  const std::string text = BadText(inputs::CheckInputs(
      frame.left, frame.right, scenes::SampleTofGrid(pair, kStepPx, frame.truth.left), rig));
  if (!text.empty()) return "the ground truth does not fit the images; taken for ranges: " + text;
  const double on_truth = scanner != nullptr ? ShareOnTruth(frame, *scanner) : 1;
  if (on_truth >= kMinShareOnTruth) return "";
  return fmt::format(
      "{:.0f} % of the scan's points lie within 1 px of the ground truth: is the calibration that "
      "of this recording?",
      100 * on_truth);
}

std::string WrongTruthText(const Scene& scene) {
  return WrongTruthText(scene.frame, scene.projector.rig().pair,
                        scene.truth_is_scan ? &scene.projector : nullptr);
}

}  // namespace sprout::evaluate
