#ifndef SPROUT_SERVICES_REFINE_ZONES_ZONE_EVIDENCE_H_
#define SPROUT_SERVICES_REFINE_ZONES_ZONE_EVIDENCE_H_

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "common/core/result.h"
#include "common/core/rig.h"
#include "common/core/tof_zones.h"
#include "services/refine/stereo/cell_grid.h"
#include "services/refine/stereo/disparity_bounds.h"

namespace sprout::refine {

/// A disparity and its standard deviation, px.
struct ZoneSurface {
  double disparity_px = 0;
  double sigma_px = 0;
};

/// What the zones of a multi-zone sensor say of the cells of the left image: an area each, not a
/// point.
class ZoneEvidence {
 public:
  /// @param zones  as FromMessage() allows them; 0×0: nothing is said of any cell.
  /// @returns an error when the zones overlap without sense (ZoneRules::kMostZonesPerCell).
  /// O(cells + zones). Keeps its memory, 20 bytes a cell.
  Result<void> Set(const TofZones& zones, const RectifiedPair& pair, const CellGrid& grid);

  /// For each cell that a zone with a target looks at, the disparities of all targets within reach
  /// (eq. 6 of the README).
  const DisparityBounds& bounds() const { return bounds_; }

  /// The plane through the zone that looks at the cell and the zones around, at the cell's centre;
  /// nothing where no zone looks, or one with several targets, a doubtful one, or MODE_NEAREST.
  /// O(1).
  std::optional<ZoneSurface> SurfaceAt(cv::Point cell) const;

 private:
  static constexpr int kNone = -1;

  // A zone in the left image; of MODE_MEAN with one target.
  struct Patch {
    bool is_one = false;  // else the rest is not set
    Eigen::Vector2d centre_px;
    Eigen::Vector2d half_px;  // half its width and height
    double disparity_px = 0;
    double variance_px2 = 0;
  };
  // d(x) = at · (1, x − centre_px), with the covariance of `at`.
  struct Plane {
    Eigen::Vector3d at;
    Eigen::Matrix3d covariance;
    double unexplained_px2 = 0;  // variance within the zone that its slant does not explain
  };

  struct Footprint;
  std::optional<Footprint> FootprintOf(const TofZones& zones, size_t zone,
                                       const RectifiedPair& pair) const;
  void Bound(const Footprint& footprint, const CellGrid& grid);
  Plane PlaneOf(const TofZones& zones, int column, int row) const;

  CellGrid grid_{1, {1, 1}};
  DisparityBounds bounds_;
  cv::Mat1i zone_;             // that looks at the cell, the nearest of several; kNone
  cv::Mat1f nearest_px_;       // its disparity
  std::vector<Patch> patches_;
  std::vector<Plane> planes_;  // of patches_
};

}  // namespace sprout::refine

#endif  // SPROUT_SERVICES_REFINE_ZONES_ZONE_EVIDENCE_H_
