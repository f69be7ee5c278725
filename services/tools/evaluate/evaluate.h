#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <opencv2/core.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/config/config.h"
#include "common/core/seed.h"
#include "common/measure/score.h"
#include "common/measure/sparsification.h"
#include "services/tools/evaluate/chain.h"
#include "services/tools/evaluate/scene.h"

namespace sprout::evaluate {

/// Whether a map is as wrong as its confidence and its standard deviations say. NaN when no pixel
/// has a disparity and is scored; pixels without a disparity claim nothing, and are left out.
struct Calibration {
  static constexpr int kBins = 10;
  /// Pixels by the claimed probability p of an error > 1 px, a tenth each: mean p, and the share
  /// whose error is > 1 px, per cent.
  struct Bin {
    double claimed_percent = 0;
    double bad1_percent = 0;
  };
  std::array<Bin, kBins> bins{};
  double claimed_percent = 0;         ///< mean p of all
  double bad1_percent = 0;            ///< share of all with an error > 1 px
  double error_points = 0;            ///< mean of |claimed − bad 1| over the bins
  double within_1_sigma_percent = 0;  ///< |error| ≤ σ
  double within_2_sigma_percent = 0;  ///< |error| ≤ 2σ
};

/// @param disparity_px, truth, mask  as Score(), of one size.
/// @param confidence, sigma          of that size, as Part::kConfidence and Part::kSigma.
/// O(pixels).
Calibration Calibrate(const cv::Mat1f& disparity_px, const cv::Mat1f& truth, const cv::Mat1b& mask,
                      const cv::Mat1b& confidence, const cv::Mat1b& sigma);

/// Error above which a seed is wrong, px.
inline constexpr double kWrongSeedPx = 3;

/// Counts of seeds, judged by the ground truth at their nearest pixel of the left image.
struct SeedCounts {
  /// At most kWrongSeedPx from the truth, on a pixel that both cameras see (NonOccludedMask()).
  int64_t good = 0;
  /// Seeds that are more than kWrongSeedPx from the truth, or on a pixel that a nearer surface
  /// hides from the right camera (OccludedMask()).
  int64_t wrong = 0;
  // Others cannot be judged: beyond the border of an image, or truth unknown.
};

/// O(n).
SeedCounts CountSeeds(std::span<const Seed> seeds, const Scene& scene);

/// How many good ToF points have no seed any more. Stereo seeds do not replace them, and a point
/// that refinement moved is not lost.
/// @param points  all ToF points. @param kept  the seeds after refinement, also those that only the
///                left camera sees: the prior has them. O(n log n).
int64_t CountGoodLost(std::span<const Seed> points, std::span<const Seed> kept, const Scene& scene);

/// Effect of refinement on the seeds of a scene, without added noise.
struct RefinementQuality {
  SeedSet refined;        ///< the seeds kept, and how many points each rule dropped
  SeedCounts before;      ///< of all ToF points
  SeedCounts after;       ///< of the seeds kept and those from stereo
  int64_t good_lost = 0;  ///< CountGoodLost()

  double wrong_before_percent() const;  ///< wrong ones among all ToF points
  double wrong_after_percent() const;   ///< wrong ones among the seeds kept and those from stereo
  double good_lost_percent() const;     ///< share of the good ToF points that was dropped
};

/// Runs refinement on a scene and evaluates it. Shares with denominator 0 are NaN.
RefinementQuality JudgeRefinement(const Scene& scene, const RefineConfig& config);

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
