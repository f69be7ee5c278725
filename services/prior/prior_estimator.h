#pragma once

#include <memory>
#include <opencv2/core.hpp>
#include <span>

#include "common/config/config.h"
#include "common/core/prior_map.h"
#include "common/core/result.h"
#include "common/core/seed.h"
#include "services/prior/triangulation/triangulation.h"

namespace sprout::prior {

/// Takes flat triangles off the hull, so that it follows the outermost seeds: one seed that lies
/// further out than a whole row of others spans a side over all of them. A triangle goes if its
/// side on the hull is longer than `max_side_px`, its third corner less than `max_depth_px` from
/// that side, and not on the hull; then its other two sides are looked at. The neighbours stay.
///
/// @param seeds  that were triangulated.
/// O(triangles); one thread.
void RemoveFlatTriangles(std::span<const Seed> seeds, double max_side_px, double max_depth_px,
                         Triangulation& triangulation);

/// The stage: a dense prior disparity map D_p of the left image, and its standard deviation, from
/// sparse seeds. The README states the method.
class PriorEstimator {
 public:
  /// @throws ConfigError for a value out of range.
  explicit PriorEstimator(const PriorConfig& config);
  ~PriorEstimator();

  /// Whether the seeds should include points that only the left camera sees.
  bool uses_left_seeds() const { return config_.left_seeds(); }

  /// Whether the method looks at the two images.
  bool uses_images() const { return config_.method() == PriorConfig::EDGES; }

  /// @param left   8UC1 or 8UC3 (BGR); may be empty when images are not used.
  /// @param right  of the same size, 8UC1 or 8UC3; may be empty when images are not used.
  /// @param seeds  at least three, finite, not all on a line; of several at one position only the
  ///               first is used.
  /// @param size   of the left rectified image, px.
  /// @returns a map of that size, every pixel with a disparity. An error that says why when the
  /// seeds span no triangle that covers a pixel, when an image that is used has another size, or
  /// when a side is longer than kMaxSide.
  /// O(n log n + pixels); at worst, when seeds make triangles as high as the image, O(n log n +
  /// pixels + n · rows). No I/O; on OpenCV's threads, with the same result for any number. Keeps
  /// maps from frame to frame, about 17 bytes a pixel, so one object serves one caller at a time;
  /// the memory of a result that nobody else holds any more is used again.
  /// @param left_grey  grey values of `left` where the caller has them; empty: they are computed.
  Result<PriorMap> Compute(const cv::Mat& left, const cv::Mat& right, std::span<const Seed> seeds,
                           cv::Size size, const cv::Mat1b& left_grey = {});

 private:
  struct Memory;

  Result<PriorMap> InterpolateOnly(std::span<const Seed> seeds, cv::Size size);
  Result<PriorMap> WithEdges(const cv::Mat& left, const cv::Mat1b& left_grey, const cv::Mat& right,
                             std::span<const Seed> seeds, cv::Size size);

  PriorConfig config_;
  std::unique_ptr<Memory> memory_;
};

}  // namespace sprout::prior
