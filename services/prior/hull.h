#ifndef SPROUT_SERVICES_PRIOR_HULL_H_
#define SPROUT_SERVICES_PRIOR_HULL_H_

#include <algorithm>
#include <cstddef>
#include <vector>

#include "common/core/disparity_image.h"
#include "services/prior/triangle_raster.h"

namespace sprout {

/// The pixels of the seeds' hull: one run in each row that has any. Keeps its memory.
class Hull {
 public:
  /// @param map  with disparities in the hull only. O(pixels beyond it).
  void Find(const DisparityImage& map);

  /// In the order of the rows.
  const std::vector<PixelRun>& runs() const { return runs_; }

  /// The run in a row, or the next below, or the last.
  size_t AtOrBelow(int v) const;

  /// The run with the pixel that is nearest to (u, v), within a pixel, by steps downhill from the
  /// one at `run`: the distance of a point to the rows of a convex shape has one minimum.
  size_t Nearest(int u, int v, size_t run) const;

  static int NearestColumn(int u, const PixelRun& run) {
    return std::clamp(u, run.begin, run.end - 1);
  }

 private:
  void FillDents(std::vector<double>& columns, double sign);
  double SquaredDistance(int u, int v, size_t run) const {
    const double across = u - std::clamp<double>(u, left_[run], right_[run]);
    const double down = v - runs_[run].v;
    return across * across + down * down;
  }

  std::vector<PixelRun> runs_;
  std::vector<double> left_;  // first and last column of each run, and a little more
  std::vector<double> right_;
  std::vector<size_t> chain_;  // of FillDents()
};

}  // namespace sprout

#endif  // SPROUT_SERVICES_PRIOR_HULL_H_
