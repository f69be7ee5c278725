#include <algorithm>
#include <cmath>
#include <vector>

#include "common/core/quantile.h"
#include "services/refine/range/range_rules.h"
#include "services/refine/range/row_shift.h"
#include "services/refine/refiner.h"

// Those parts of the refiner that find sensors which are not where they are thought to be.
namespace sprout::refine {

// Whether the points are wrong in places, or at their edges.
bool Refiner::ErrsInPlaces() const {
  return doubts_edges_ || found_.fattening ||
         found_.range_error.far_from_curve_share > RangeRules::kDoubtfulMoves;
}

// Stereo reaches as far as the points do: if it ended before, what is near would match elsewhere,
// and contradict right points.
void Refiner::SearchAsFarAsPoints(int columns) {
  stereo_.SetReach(0);
  const auto most_px = static_cast<float>(stereo_.MostDisparityPx(columns));
  std::vector<float> disparities;
  for (const ProjectedPoint& point : points_) disparities.push_back(point.seed.disparity());
  const auto near = std::ranges::count_if(disparities, [&](float px) { return px > most_px; });
  const double share = RangeRules::kNearShare;
  if (static_cast<double>(near) <= share * static_cast<double>(disparities.size())) return;
  const float nearest_px = Quantile(disparities, 1 - share / 2);
  stereo_.SetReach(std::min(static_cast<int>(std::ceil(nearest_px)), columns / 2));
}

// Whether much is wrong with the points, or they are nearer than anything that stereo looks for.
bool Refiner::IsDoubtful() const {
  if (found_.range_error.RejectsAll() || found_.range_error.pair_unfit) return false;
  if (!config_.stereo_seeds()) return false;
  // A scan's few points give too few nodes to judge by.
  if (!surface_.has_pixels()) {
    return found_.range_error.contradicted_share > RangeRules::kDoubtfulScan ||
           found_.range_error.moved_share > 0 || found_.scan_move.is_off ||
           points_.size() < RangeRules::kFewScanPoints;
  }
  return ErrsInPlaces() || found_.range_error.IsBeyondDataSheets() ||
         found_.range_error.contradicted_share > RangeRules::kDoubtfulShare ||
         stereo_.reach_px() > 0;
}

// Whether the pair is at fault, not the points.
bool Refiner::PairShiftsRows(const PlacedPoints& points, std::span<const Seed> matches) {
  if (found_.range_error.moved_share > 0 || !ShiftsRows(points, matches)) return false;
  found_.range_error.pair_unfit = found_.range_error.rows_shifted = true;
  found_.range_error.curve.clear();
  return true;
}

// Whether stereo that knows nothing of the points shows that all belong elsewhere, or contradicts
// all; if not, which it contradicts. Asked only where much is wrong with them: first of coarse
// matches, which take a fifth of the time.
bool Refiner::IsDisplaced(const cv::Mat1b& left, const cv::Mat1b& right, const TofImage& tof,
                          const TofProjector& projector) {
  if (!IsDoubtful()) return false;
  PlacedPoints points{.raw = {},
                      .corrected = points_,
                      .spacing_px = {surface_.column_px(), surface_.row_px()},
                      .image = left.size(),
                      .infinity_px = projector.rig().pair.cx - projector.rig().pair.cx_right};
  if (!surface_.has_pixels()) {
    points.raw = HasUnmovedScan() ? before_move_ : points_;
    return IsWrongScan(left, right, points);
  }
  int behind = 0;
  const std::vector<ProjectedPoint> raw = projector.Project(tof, behind);
  points.raw = raw;
  double error_px = 0;
  const std::span<const Seed> coarse = stereo_.FindCoarse(left, right, error_px);
  const double coarse_px = RangeRules::kAgreePx + error_px;
  const bool differs = !FindContradicted(left, right, points, coarse, coarse_px).points.empty();
  const bool may_be_displaced =
      FindSensorPlace(points, coarse, coarse_px, RangeRules::kFirstLook).is_displaced;
  if (!differs && !may_be_displaced && !ErrsInPlaces()) return false;
  const std::span<const Seed> matches = stereo_.Find(left, right, {}, {}, 0, zones_.most_px());
  if (PairShiftsRows(points, matches)) return false;
  found_.sensor_place = FindSensorPlace(points, matches, RangeRules::kAgreePx);
  if ((differs || ErrsInPlaces()) && !found_.sensor_place.is_displaced) {
    const CellGrid cells(stereo_.SpacingPx(left.cols), left.size());
    found_.contradiction = FindContradicted(left, right, points, matches, RangeRules::kAgreePx,
                                            ErrsInPlaces() ? &cells : nullptr,
                                            found_.fattening ? 1 : RangeRules::kUnexplained);
  }
  const auto is_contradicted = [](uint8_t is) { return is != 0; };
  return found_.sensor_place.is_displaced ||
         (!found_.contradiction.points.empty() &&
          std::ranges::all_of(found_.contradiction.points, is_contradicted));
}

// Points of a scan are compared with the matches at their own places alone: between beams the scene
// may differ. As above coarse matches are asked first, all of them: where a road recedes, those
// beside a point are off.
bool Refiner::IsWrongScan(const cv::Mat1b& left, const cv::Mat1b& right,
                          const PlacedPoints& points) {
  const double reach_px = stereo_.SpacingPx(left.cols);
  double error_px = 0;
  const std::span<const Seed> coarse = stereo_.FindCoarse(left, right, error_px, 1);
  const bool contradicts =
      ShareAgainst(left, right, points_, coarse, reach_px) > RangeRules::kDoubtfulScan;
  const bool may_be_displaced =
      FindScanPlace(points, coarse, 2 * error_px, RangeRules::kAgreePx + error_px,
                    RangeRules::kFirstLook)
          .is_displaced;
  if (!contradicts && !may_be_displaced) return false;
  const std::span<const Seed> matches = stereo_.Find(left, right, {}, {}, 0, zones_.most_px());
  if (PairShiftsRows(points, matches)) return false;
  found_.sensor_place = FindScanPlace(points, matches, reach_px, RangeRules::kAgreePx);
  if (found_.sensor_place.is_displaced) {
    found_.scan_move = {};
    return true;
  }
  const double share = ShareAgainst(left, right, points_, matches, reach_px);
  if (share <= RangeRules::kWrongScan) return false;
  found_.contradiction = {.points = std::vector<uint8_t>(points_.size(), 1), .share = share};
  return true;
}

// Whether before_move_ has the points of the scan as they were projected.
bool Refiner::HasUnmovedScan() const {
  return !surface_.has_pixels() && before_move_.size() == points_.size();
}

// Puts a scan right which stereo shows to be farther off than its alignment looks by itself.
bool Refiner::AlignAgain(const cv::Mat1b& left, const cv::Mat1b& right, const Rig& rig) {
  const SensorPlace& place = found_.sensor_place;
  if (!HasUnmovedScan() || !place.is_displaced || !place.IsMove()) return false;
  points_ = before_move_;
  surface_.Set(rig, points_);
  found_.scan_move = scan_aligner_.Estimate(InputOf(left, right, rig), points_, &place.move_px);
  if (!found_.scan_move.is_off) return false;
  found_.sensor_place = {};
  ApplyMove(found_.scan_move, rig, points_);
  surface_.Set(rig, points_);
  return true;
}

}  // namespace sprout::refine
