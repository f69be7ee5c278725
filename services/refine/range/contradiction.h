#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "services/refine/range/range_rules.h"
#include "services/refine/range/sensor_place.h"
#include "services/refine/stereo/point_surface.h"

namespace sprout::refine {

/// Which points stereo contradicts, see FindContradicted().
struct Contradiction {
  /// 1 or 0 for each of PlacedPoints::corrected; empty where stereo contradicts none.
  std::vector<uint8_t> points;
  double share = 0;  ///< of the matches that voted, 0 to 1
  /// Standard deviation of each corrected point's error as the matches around show it, px, up to
  /// RangeRules::kAgreePx; empty where those that the points have explain it, or if not asked.
  std::vector<float> sigma_px = {};
};

/// Asks of each corrected point whether stereo contradicts it: of the matches around it on its
/// surface in the range image, more than a third differ from all points beside them, and the images
/// prefer them to these; the nearest count most. Where no match is near, all of the surface count.
/// Nothing is contradicted if hardly more matches differ than with right sensors.
/// @param left, right  rectified pair, grey.
/// @param matches, agree_px  as for FindSensorPlace().
/// @param cells_of_matches   null, or the cells that `matches` were looked for in, one each: then
///                           the errors of the points are asked, too.
/// @param unexplained  from how many times the squares that both claim on these are told, eq. (B4).
/// O(points + matches). No I/O; one thread; the same on every machine.
Contradiction FindContradicted(const cv::Mat1b& left, const cv::Mat1b& right,
                               const PlacedPoints& points, std::span<const Seed> matches,
                               double agree_px, const CellGrid* cells_of_matches = nullptr,
                               double unexplained = RangeRules::kUnexplained);

/// Share of a scan's points that stereo contradicts, of those that a match lies beside: none of the
/// matches within `reach_px` agrees, and at the point's own place the images prefer the disparity
/// of the nearest one, whose windows are alike.
/// @param matches   at most about one in each square of `reach_px`; of more the last one counts.
/// @param reach_px  above 0.
/// @returns 0 to 1; 0 also where fewer than RangeRules::kMinScanPoints points can be asked.
/// O(points + matches). No I/O; one thread; the same on every machine.
double ShareAgainst(const cv::Mat1b& left, const cv::Mat1b& right,
                    std::span<const ProjectedPoint> points, std::span<const Seed> matches,
                    double reach_px);

}  // namespace sprout::refine
