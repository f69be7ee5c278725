#include "services/tools/evaluate/evaluate.h"

#include "common/core/quantile.h"

namespace sprout::evaluate {
namespace {

double MedianOf(const std::vector<StageTimes>& runs, double StageTimes::*stage) {
  std::vector<double> times;
  for (const StageTimes& run : runs) times.push_back(run.*stage);
  return Median(times);
}

StageTimes Medians(const std::vector<StageTimes>& runs) {
  StageTimes median;
  for (double StageTimes::*stage :
       {&StageTimes::refine_ms, &StageTimes::prior_ms, &StageTimes::grow_ms, &StageTimes::fill_ms,
        &StageTimes::total_ms}) {
    median.*stage = MedianOf(runs, stage);
  }
  return median;
}

cv::Mat1b TestPixels(const Scene& scene) {
  if (!scene.truth_is_scan) return scene.nonoccluded;
  cv::Mat1b both;
  cv::bitwise_and(scene.nonoccluded, scene.away, both);
  return both;
}

MethodResult EvaluateMethod(const Scene& scene, const Method& method, const ChainSettings& settings,
                            int repeat) {
  MethodOutput output;
  std::vector<StageTimes> runs;
  for (int i = 0; i < repeat; ++i) {
    output = method.run(scene, settings);
    runs.push_back(output.ms);
  }
  const cv::Mat1f& truth = scene.frame.truth.left;
  const cv::Mat1b everywhere(scene.size(), uchar{255});
  std::optional<Sparsification> confidence;
  std::optional<Calibration> calibration;
  if (!output.confidence.empty()) {
    const cv::Mat1b scored = TestPixels(scene);
    confidence = Sparsify(output.map_px, truth, scored, output.confidence);
    if (!output.sigma.empty()) {
      calibration = Calibrate(output.map_px, truth, scored, output.confidence, output.sigma);
    }
  }
  return {.name = method.name,
          .nonoccluded = Score(output.map_px, truth, scene.nonoccluded).value(),
          .all = Score(output.map_px, truth, everywhere).value(),
          .away = Score(output.map_px, truth, scene.away).value(),
          .confidence = confidence,
          .calibration = calibration,
          .ms = Medians(runs),
          .map_px = output.map_px};
}

}  // namespace

SceneResult EvaluateScene(const Scene& scene, const std::vector<Method>& methods,
                          const ChainSettings& settings, int repeat, const OnMethod& on_method) {
  SceneResult result{.name = scene.name,
                     .size = scene.size(),
                     .refinement = JudgeRefinement(scene, settings.config.refine())};
  for (const Method& method : methods) {
    on_method(method);
    result.methods.push_back(EvaluateMethod(scene, method, settings, repeat));
  }
  return result;
}

}  // namespace sprout::evaluate
