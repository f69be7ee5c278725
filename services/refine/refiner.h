#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "common/config/config.h"
#include "common/core/result.h"
#include "common/core/seed.h"
#include "common/core/tof_image.h"
#include "common/core/tof_zones.h"
#include "common/geometry/projection.h"
#include "services/refine/alignment/scan_alignment.h"
#include "services/refine/alignment/tof_alignment.h"
#include "services/refine/findings.h"
#include "services/refine/range/range_bias.h"
#include "services/refine/stereo/point_surface.h"
#include "services/refine/stereo/stereo_seeds.h"
#include "services/refine/stereo/unsure_points.h"
#include "services/refine/surface/background.h"
#include "services/refine/surface/tof_surface.h"
#include "services/refine/unwrapping/range_unwrapper.h"
#include "services/refine/zones/zone_evidence.h"

namespace sprout::refine {

/// Turns ToF points into seed correspondences and drops the unreliable ones: by the paper's rules
/// (II-B) and by two of TofSurface, which a sensor beside the left camera needs. Before that,
/// RangeUnwrapper corrects points beyond the sensor's unambiguous range, and TofAligner corrects a
/// calibration that is slightly wrong. Where the sensor gives nothing, StereoSeedFinder adds seeds
/// from the pair, and ZoneEvidence bounds and completes these by the zones of a multi-zone sensor.
class Refiner {
 public:
  /// @throws ConfigError when a value is out of range.
  explicit Refiner(const RefineConfig& config);

  /// @param left, right  rectified pair of the calibrated size, grey.
  /// @param tof          range image of the calibrated size (a precondition); empty for a rig that
  ///                     has no ToF camera.
  /// @param projector    of the calibration; costly to make, so keep it from frame to frame.
  /// @param zones        of a multi-zone sensor; 0×0 without one.
  /// @returns the seeds in the order of the ToF pixels, behind them those of stereo, and how many
  ///          points were dropped by which rule; a point is counted under the first of
  ///          contradicted, outside, dark, loose, background, hidden that applies. Seeds keep their
  ///          sub-pixel positions. An error when the images do not have the calibrated size, or
  ///          when zones overlap without sense.
  /// O(ToF pixels), with the background or the hidden rule also O(image pixels / 25); where points
  /// crowd into a few pixels, up to 20 µs a point (300 neighbours each); stereo seeds O(pixels
  /// without ToF points), about 0.1 µs each. No I/O; on OpenCV's threads, with the same result for
  /// any number. Keeps its memory from frame to frame, about 120 bytes a ToF pixel, and with stereo
  /// 100 a pixel of the matched image; so one object serves one caller at a time.
  Result<SeedSet> Compute(const cv::Mat1b& left, const cv::Mat1b& right, const TofImage& tof,
                          const TofProjector& projector, const TofZones& zones = {});

  /// The frames of the next calls have so many columns more than the cameras' images, see
  /// Widened(); 0: none.
  void SetColumns(int columns) { stereo_.SetColumns(columns); }

  /// The disparity of a point at infinity in the next frames, px, ≥ 0.
  void SetInfinity(int disparity_px) { stereo_.SetInfinity(disparity_px); }

  /// What was found in the last call.
  const RefineFindings& found() const { return found_; }

  /// See StereoSeedFinder.
  double ShareBelowZero(const cv::Mat1b& left, const cv::Mat1b& right, int columns) {
    return stereo_.ShareBelowZero(left, right, columns);
  }

  /// Reliable points of the last call that only the left camera sees, since they lie outside the
  /// right image or behind a nearer surface in it. They are no correspondences, but give depth
  /// where stereo cannot; and what zones say of places that nothing else explains. u_right is where
  /// the right camera would see them. Their `raw` counts such points before the rules for dark,
  /// loose and (from the left camera) hidden points; the counts of the seeds list all of them as
  /// outside or hidden.
  const SeedSet& left_seeds() const { return left_seeds_; }

 private:
  // What becomes of a point, whether or not the right camera sees it.
  enum class Fate : uint8_t { kKept, kOutside, kDark, kLoose };

  Fate FateOf(const ProjectedPoint& point, const cv::Mat1b& left, const cv::Mat1b& right,
              const TofImage& tof) const;
  void KeepReliable(const cv::Mat1b& left, const cv::Mat1b& right, const TofImage& tof,
                    SeedSet& result);
  RangeInput InputOf(const cv::Mat1b& left, const cv::Mat1b& right, const Rig& rig);
  void Align(const cv::Mat1b& left, const cv::Mat1b& right, const TofImage& tof,
             const TofProjector& projector);
  void CorrectRanges(const cv::Mat1b& left, const cv::Mat1b& right, const TofImage& tof,
                     const TofProjector& projector, SeedSet& result);
  void DropBesideEdges(const cv::Mat1b& left, const cv::Mat1b& right, const Rig& rig,
                       SeedSet& result);
  void UndoCorrections(const Rig& rig, SeedSet& result);
  bool ErrsInPlaces() const;
  bool IsDoubtful() const;
  void SearchAsFarAsPoints(int columns);
  bool PairShiftsRows(const PlacedPoints& points, std::span<const Seed> matches);
  bool IsWrongScan(const cv::Mat1b& left, const cv::Mat1b& right, const PlacedPoints& points);
  bool IsDisplaced(const cv::Mat1b& left, const cv::Mat1b& right, const TofImage& tof,
                   const TofProjector& projector);
  bool HasUnmovedScan() const;
  bool AlignAgain(const cv::Mat1b& left, const cv::Mat1b& right, const Rig& rig);
  void DropNoise();
  RangeNoise Noise(const cv::Mat1b& left, const cv::Mat1b& right);
  void AddNoise(const cv::Mat1b& left, const cv::Mat1b& right);
  void AddStereo(const cv::Mat1b& left, const cv::Mat1b& right, const CellGrid& grid,
                 SeedSet& result);
  std::span<const cv::Point2f> Covered(bool dense);
  void FillFromZones(const SeedSet& result, const CellGrid& grid, cv::Size image);
  void KeepVisible(const cv::Mat1b& left, const cv::Mat1b& right, SeedSet& result);

  RefineConfig config_;
  RefineFindings found_;
  // Memory of the last frame, for the next.
  std::vector<ProjectedPoint> points_;
  std::vector<Fate> fates_;  // of points_
  RangeUnwrapper unwrapper_;
  TofAligner aligner_;
  ScanAligner scan_aligner_;
  TofSurface surface_;
  RangeBias range_;
  std::vector<ProjectedPoint> before_fattening_;
  bool doubts_edges_ = false;  // depth edges seem to be moved, but points fit no better there
  std::vector<ProjectedPoint> before_move_;  // as projected, if they were moved
  UnsurePoints unsure_;
  RangeNoise noise_;                  // of the points
  std::vector<ProjectedPoint> kept_;  // first those whose window lies in both images
  size_t kept_in_both_ = 0;
  SeedSet left_seeds_;
  BackgroundRule background_;
  std::vector<cv::Point2f> covered_;
  StereoSeedFinder stereo_;
  ZoneEvidence zones_;
  std::vector<Seed> all_seeds_;
  PointSurface all_points_;
};

}  // namespace sprout::refine
