#ifndef SPROUT_SERVICES_REFINE_REFINER_H_
#define SPROUT_SERVICES_REFINE_REFINER_H_

#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "common/config/config.h"
#include "common/core/result.h"
#include "common/core/seed.h"
#include "common/core/tof_image.h"
#include "common/geometry/projection.h"

namespace sprout {

/// Turns ToF points into seed correspondences and drops the unreliable ones: by the paper's rules
/// (II-B) and by two of TofSurface, which a sensor needs that stands beside the left camera.
class Refiner {
 public:
  /// Side of the window that the paper's rules look at, px.
  static constexpr int kWindow = 5;

  /// @throws ConfigError when a value is out of range.
  explicit Refiner(const RefineConfig& config);

  /// @param left, right  rectified pair of the calibrated size, grey.
  /// @param tof          range image of the calibrated size (a precondition).
  /// @param projector    of the calibration; worth keeping from frame to frame.
  /// @returns the seeds in the order of the ToF pixels, and how many were dropped by which rule; a
  ///          point is counted under the first of outside, dark, loose, background, hidden that
  ///          applies. Seeds keep their sub-pixel positions. An error when the images do not have
  ///          the calibrated size.
  /// O(ToF pixels + image pixels); no I/O; thread-compatible.
  Result<SeedSet> Compute(const cv::Mat1b& left, const cv::Mat1b& right, const TofImage& tof,
                          const TofProjector& projector) const;

 private:
  std::vector<ProjectedPoint> DropOutsideAndDark(const cv::Mat1b& left, const TofImage& tof,
                                                 const RectifiedPair& pair,
                                                 const std::vector<ProjectedPoint>& points,
                                                 SeedSet& counts) const;

  RefineConfig config_;
};

/// The background rule alone: which seeds are background beside a nearer one. In the 5×5 window
/// around each seed, in the left image and in the right one, every seed whose disparity is smaller
/// than the window's largest by more than the tolerance.
/// @returns one flag a seed. Does not depend on the order of the seeds. O(n) for seeds that are
///          spread as a sensor's.
std::vector<bool> FindBackground(std::span<const Seed> seeds, cv::Size size, double tolerance_px);

}  // namespace sprout

#endif  // SPROUT_SERVICES_REFINE_REFINER_H_
