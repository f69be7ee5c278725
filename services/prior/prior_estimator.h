#ifndef SPROUT_SERVICES_PRIOR_PRIOR_ESTIMATOR_H_
#define SPROUT_SERVICES_PRIOR_PRIOR_ESTIMATOR_H_

#include <opencv2/core.hpp>
#include <span>

#include "common/config/config.h"
#include "common/core/disparity_image.h"
#include "common/core/result.h"
#include "common/core/seed.h"
#include "services/prior/edge_hypotheses.h"

namespace sprout {

/// The stage: a dense prior disparity map D_p of the left image from sparse seeds.
class PriorEstimator {
 public:
  /// @throws ConfigError for a value out of range.
  explicit PriorEstimator(const PriorConfig& config);

  /// Whether the method looks at the left, and at the right image.
  bool uses_left() const { return config_.method() != PriorConfig::DELAUNAY; }
  bool uses_right() const { return config_.method() == PriorConfig::EDGES; }

  /// @param left   8UC1 or 8UC3 (BGR); may be empty when it is not used.
  /// @param right  of the same size, 8UC1 or 8UC3; may be empty when it is not used.
  /// @param seeds  at least three, not all on a line; of seeds on one position the first counts.
  /// @param size   of the left rectified image, px.
  /// @returns a map of that size. An error that says why when the seeds span no triangle that
  ///          covers a pixel, or when an image that is used has another size.
  /// O(n log n + pixels); no I/O; on OpenCV's threads, with the same result for any number. Keeps
  /// three maps' memory from frame to frame, so one object serves one caller at a time.
  Result<DisparityImage> Compute(const cv::Mat& left, const cv::Mat& right,
                                 std::span<const Seed> seeds, cv::Size size);

 private:
  DisparityImage FromSpreadSeeds(const cv::Mat& left, std::span<const Seed> seeds,
                                 const DisparityImage& interpolated) const;
  Result<DisparityImage> WithEdges(const cv::Mat& left, const cv::Mat& right,
                                   std::span<const Seed> seeds, cv::Size size);

  PriorConfig config_;
  // Memory of the last frame, for the next; neither is ever handed out.
  EdgeHypotheses hypotheses_;
  DisparityImage prior_;
};

}  // namespace sprout

#endif  // SPROUT_SERVICES_PRIOR_PRIOR_ESTIMATOR_H_
