#ifndef SPROUT_SERVICES_TOOLS_EVALUATE_EVALUATE_H_
#define SPROUT_SERVICES_TOOLS_EVALUATE_EVALUATE_H_

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "common/measure/score.h"
#include "common/measure/sparsification.h"
#include "services/tools/evaluate/calibration.h"
#include "services/tools/evaluate/chain.h"
#include "services/tools/evaluate/scene.h"
#include "services/tools/evaluate/seed_quality.h"

namespace sprout::evaluate {

/// One row of the tables: a way to a disparity map.
struct Method {
  std::string name;
  std::string summary;  ///< one line for --help
  std::function<MethodOutput(const Scene&, const ChainSettings&)> run;
};

/// Every method, in the order of the tables: sprout, those of the paper's table, rivals.
std::vector<Method> AllMethods();

/// The methods of that name or in that group ("paper": those of the paper's table, "all"), in the
/// order asked for, each once.
/// @throws ConfigError for an unknown name, listing those that exist.
std::vector<Method> SelectMethods(const std::vector<std::string>& names);

/// One method on one scene.
struct MethodResult {
  std::string name;
  Accuracy nonoccluded = {};  ///< on the pixels that both cameras see
  Accuracy all = {};          ///< on all pixels with a known truth
  Accuracy away = {};         ///< on those of them away from every ToF point
  /// How well the whole chain's confidence ranks the pixels that both cameras see, on KITTI only
  /// those away from every ToF point.
  std::optional<Sparsification> confidence = {};
  std::optional<Calibration> calibration = {};  ///< where it claims probabilities
  StageTimes ms = {};                           ///< median of each stage's times
  cv::Mat1f map_px = {};                        ///< NaN = none
};

struct SceneResult {
  std::string name;
  cv::Size size;
  std::vector<MethodResult> methods = {};
  RefinementQuality refinement = {};
};

/// Called before each method.
using OnMethod = std::function<void(const Method&)>;

/// Runs the methods on a scene, one after another, and scores their maps.
/// @param repeat  how often each runs, for the median of its times; the map is the same each time.
SceneResult EvaluateScene(const Scene& scene, const std::vector<Method>& methods,
                          const ChainSettings& settings, int repeat, const OnMethod& on_method);

}  // namespace sprout::evaluate

#endif  // SPROUT_SERVICES_TOOLS_EVALUATE_EVALUATE_H_
