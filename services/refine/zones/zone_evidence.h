#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "common/core/result.h"
#include "common/core/rig.h"
#include "common/core/tof_zones.h"
#include "services/refine/stereo/point_surface.h"

namespace sprout::refine {

/// The constants of zones. NOTES.md has what was measured.
struct ZoneRules {
  /// How many standard deviations a target's surface is nearer at most, and how many a zone's plane
  /// must be off all planes of seeds around to add information. The smaller surface of a target
  /// with two is 3 away if it has a tenth of the light.
  static constexpr double kSigmas = 3;
  /// How many times less sure the seeds around must be than the zone. Measured.
  static constexpr double kSurer = 4;
  /// A target bounds disparities up to this many widths and heights of its zone beyond the zone's
  /// sides: a surface that one zone hardly sees fills the next one.
  static constexpr double kReach = 1;
  /// Zones fill no cell with a seed in so many cells around. Measured.
  static constexpr int kGapCells = 2;
  /// Most zones within whose reach a place of the left image lies, on average; a message with more
  /// makes no sense. A grid has 9, and as many again beside depth edges.
  static constexpr int kMaxZonesPerCell = 64;
  /// Scale of the M-estimator for the planes of zones, px of disparity a px: the prior's
  /// plane_scale_per_spacing, and its wider first round.
  static constexpr double kPlaneScalePerPx = 0.12;
  static constexpr double kFirstScale = 1.5;
  /// The scale is at least this many standard deviations of both zones, as in the prior.
  static constexpr double kPlaneScaleSigmas = 2;
};

/// A disparity and its standard deviation, px.
struct ZoneSurface {
  double disparity_px = 0;
  double sigma_px = 0;
};

/// A zone of MODE_MEAN with one target, in the left image.
struct ZonePatch {
  bool is_one = false;  ///< else the rest is not used
  Eigen::Vector2d centre_px = Eigen::Vector2d::Zero();
  double disparity_px = 0;
  double variance_px2 = 0;
};

/// What the zones of a multi-zone sensor say of the cells of the left image: of an area each, not
/// of a point.
class ZoneEvidence {
 public:
  /// @param zones  as FromMessage() allows them; 0×0: nothing is said of any cell.
  /// @returns an error when the zones overlap without sense (ZoneRules::kMaxZonesPerCell).
  /// O(cells + zones). Keeps its memory, 12 bytes a cell.
  Result<void> Set(const TofZones& zones, const RectifiedPair& pair, const CellGrid& grid);

  /// For each cell that a zone with a target looks at, the largest disparity that the targets
  /// within reach allow (eq. (Z1) of the README); infinite elsewhere. Empty without zones.
  const cv::Mat1f& most_px() const { return most_px_; }

  /// The plane through the zone that looks at the cell and the zones around, at the cell's centre
  /// (eqs. (Z2) and (Z3)); nothing where no zone looks, or one with several targets, a doubtful
  /// one, or MODE_NEAREST. O(1); thread-safe.
  std::optional<ZoneSurface> SurfaceAt(cv::Point cell) const;

 private:
  static constexpr int kNone = -1;

  // d(x) = at · (1, x − centre_px), with the covariance of `at`.
  struct Plane {
    Eigen::Vector3d at = Eigen::Vector3d::Zero();
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  };

  Plane PlaneOf(const TofZones& zones, int column, int row) const;

  CellGrid grid_{1, {1, 1}};
  cv::Mat1f most_px_;
  cv::Mat1i zone_;        // that looks at the cell, the nearest of several; kNone
  cv::Mat1f nearest_px_;  // its disparity
  std::vector<ZonePatch> patches_;
  std::vector<Plane> planes_;  // of patches_
};

/// Whether a zone's surface says of a cell what the seeds around do not: it is kSurer times surer
/// than they are, and kSigmas off all of their planes.
/// @param seeds  all that are known there. O(1); thread-safe.
bool AddsInformation(const ZoneSurface& surface, const PointSurface& seeds, cv::Point cell);

}  // namespace sprout::refine
