#include <algorithm>

#include "services/refine/range/range_rules.h"
#include "services/refine/range/row_shift.h"
#include "services/refine/refiner.h"

// Those parts of the refiner that find sensors which are not where they are thought to be.
namespace sprout::refine {

// Whether much is wrong with the points, or they are nearer than anything that stereo looks for.
bool Refiner::IsDoubtful(int columns) const {
  if (found_.range_error.Refuses() || found_.range_error.pair_unfit) return false;
  if (!config_.stereo_seeds()) return false;
  // Of few points nodes are too few to judge by.
  if (!surface_.has_pixels()) {
    return found_.range_error.contradicted_share > RangeRules::kDoubtfulScan ||
           found_.range_error.moved_share > 0 || points_.size() < RangeRules::kFewOfScan;
  }
  const auto most_px = static_cast<float>(stereo_.MostDisparityPx(columns));
  const auto near = std::ranges::count_if(
      points_, [&](const ProjectedPoint& point) { return point.seed.disparity() > most_px; });
  return found_.fattening || found_.range_error.IsBeyondDataSheets() ||
         found_.range_error.contradicted_share > RangeRules::kDoubtfulShare ||
         found_.range_error.far_from_curve_share > RangeRules::kDoubtfulMoves ||
         static_cast<double>(near) > RangeRules::kNearShare * static_cast<double>(points_.size());
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
  if (!IsDoubtful(left.cols)) return false;
  PlacedPoints points{.raw = {},
                      .corrected = points_,
                      .spacing_px = {surface_.column_px(), surface_.row_px()},
                      .image = left.size(),
                      .infinity_px = projector.rig().pair.cx - projector.rig().pair.cx_right};
  if (!surface_.has_pixels()) return IsWrongScan(left, right, points);
  int behind = 0;
  const std::vector<ProjectedPoint> raw = projector.Project(tof, behind);
  points.raw = raw;
  double error_px = 0;
  const std::span<const Seed> coarse = stereo_.FindCoarse(left, right, error_px);
  const double coarse_px = RangeRules::kAgreePx + error_px;
  const bool differs = !FindContradicted(left, right, points, coarse, coarse_px).points.empty();
  const bool may_be_displaced =
      FindSensorPlace(points, coarse, coarse_px, RangeRules::kFirstLook).is_displaced;
  const bool errs =
      found_.fattening || found_.range_error.far_from_curve_share > RangeRules::kDoubtfulMoves;
  if (!differs && !may_be_displaced && !errs) return false;
  const std::span<const Seed> matches = stereo_.Find(left, right, {}, {}, 0, zones_.most_px());
  if (PairShiftsRows(points, matches)) return false;
  found_.sensor_place = FindSensorPlace(points, matches, RangeRules::kAgreePx);
  if ((differs || errs) && !found_.sensor_place.is_displaced) {
    const CellGrid cells(stereo_.SpacingPx(left.cols), left.size());
    found_.contradiction =
        FindContradicted(left, right, points, matches, RangeRules::kAgreePx,
                         errs ? &cells : nullptr, found_.fattening ? 1 : RangeRules::kUnexplained);
  }
  const auto is_contradicted = [](uint8_t is) { return is != 0; };
  return found_.sensor_place.is_displaced ||
         (!found_.contradiction.points.empty() &&
          std::ranges::all_of(found_.contradiction.points, is_contradicted));
}

// Points of a scan are compared with the matches at their own places alone: between beams the scene
// may differ. As above coarse matches are asked first.
bool Refiner::IsWrongScan(const cv::Mat1b& left, const cv::Mat1b& right,
                          const PlacedPoints& points) {
  const double reach_px = stereo_.SpacingPx(left.cols);
  const auto share_against = [&](std::span<const Seed> matches) {
    return ShareAgainst(left, right, points_, matches, reach_px);
  };
  double error_px = 0;
  if (share_against(stereo_.FindCoarse(left, right, error_px)) <= RangeRules::kDoubtfulScan) {
    return false;
  }
  const std::span<const Seed> matches = stereo_.Find(left, right, {}, {}, 0, zones_.most_px());
  if (PairShiftsRows(points, matches)) return false;
  const double share = share_against(matches);
  if (share <= RangeRules::kWrongScan) return false;
  found_.contradiction = {.points = std::vector<uint8_t>(points_.size(), 1), .share = share};
  return true;
}

}  // namespace sprout::refine
