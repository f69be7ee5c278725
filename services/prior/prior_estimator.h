#ifndef SPROUT_SERVICES_PRIOR_PRIOR_ESTIMATOR_H_
#define SPROUT_SERVICES_PRIOR_PRIOR_ESTIMATOR_H_

#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "common/config/config.h"
#include "common/core/disparity_image.h"
#include "common/core/median.h"
#include "common/core/prior_map.h"
#include "common/core/result.h"
#include "common/core/seed.h"
#include "services/prior/border.h"
#include "services/prior/delaunay.h"
#include "services/prior/edge_hypotheses.h"
#include "services/prior/edge_triangles.h"
#include "services/prior/interpolation.h"
#include "services/prior/seed_surface.h"
#include "services/prior/seed_votes.h"

namespace sprout {

/// The stage: a dense prior disparity map D_p of the left image from sparse seeds, and how sure it
/// is.
class PriorEstimator {
 public:
  /// @throws ConfigError for a value out of range.
  explicit PriorEstimator(const PriorConfig& config);

  /// Whether the seeds should have those among them that only the left camera sees.
  bool uses_left_seeds() const { return config_.left_seeds(); }

  /// Whether the method looks at the left, and at the right image.
  bool uses_left() const { return config_.method() != PriorConfig::DELAUNAY; }
  bool uses_right() const { return config_.method() == PriorConfig::EDGES; }

  /// @param left   8UC1 or 8UC3 (BGR); may be empty when it is not used.
  /// @param right  of the same size, 8UC1 or 8UC3; may be empty when it is not used.
  /// @param seeds  at least three, finite, not all on a line; of seeds on one position the first
  /// counts.
  /// @param size   of the left rectified image, px.
  /// @returns a map of that size, with its standard deviation by PaintSigma(). An error that says
  /// why when the seeds span no triangle that covers a pixel, when an image that
  ///          is used has another size, or when a side is longer than kLargestSide.
  /// O(n log n + pixels); at worst, when seeds make triangles as high as the image, O(n log n +
  /// pixels + n · rows). No I/O; on OpenCV's threads, with the same result for any number. Keeps
  /// its memory from frame to frame (EDGES: about 17 bytes a pixel, 500 a seed and 1600 a triangle
  /// across an edge), so one object serves one caller at a time; a map that nobody else holds any
  /// more is used again. Allocates nothing in steady state.
  Result<PriorMap> Compute(const cv::Mat& left, const cv::Mat& right, std::span<const Seed> seeds,
                           cv::Size size);

 private:
  // The images in the forms that EdgeJudge looks at. Only what had to be converted is here.
  struct Images {
    cv::Mat3b left_bgr;
    cv::Mat1b left_grey;
    cv::Mat1b right_grey;
    cv::Mat1b left_census;
    cv::Mat1b right_census;
  };

  Result<DisparityImage> Disparities(const cv::Mat& left, const cv::Mat& right,
                                     std::span<const Seed> seeds, cv::Size size);
  void SpreadOver(const cv::Mat& left, std::span<const Seed> seeds);
  Result<DisparityImage> WithEdges(const cv::Mat& left, const cv::Mat& right,
                                   std::span<const Seed> seeds, cv::Size size);

  PriorConfig config_;
  Triangulator triangulator_;
  SeedInterpolator interpolator_;
  SeedSurfaceFitter fitter_;
  // Memory of the last frame, for the next. Of the maps only the result is ever handed out.
  Images images_;
  BorderExtender extender_;
  std::vector<Seed> fitted_seeds_;
  EdgeTriangleFinder edge_finder_;
  EdgeHypotheses hypotheses_;
  SeedVotes seed_votes_;
  DisparityImage interpolated_;
  MedianFilter median_;
  DisparityImage result_;
  std::vector<LocalPlane> level_planes_;
  cv::Mat1b sigma_;
};

}  // namespace sprout

#endif  // SPROUT_SERVICES_PRIOR_PRIOR_ESTIMATOR_H_
