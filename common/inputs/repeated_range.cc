#include "common/inputs/repeated_range.h"

#include <algorithm>
#include <cmath>

namespace sprout::inputs {
namespace {

struct RepeatedRules {
  static constexpr int kFewest = 20;
  static constexpr double kShare = 0.005;  ///< of the pixels
  /// Of the next smaller range: walls of one distance are not measured as one number, and numbers
  /// of a rounded depth lie nearer to each other.
  static constexpr double kGap = 1.25;
  static constexpr int kRows = 4;    ///< a beam of a lidar meets a flat road at one distance
  static constexpr int kCellPx = 8;  ///< beside a point is in its cell of the picture
  /// A disparity agrees to 1 px and 3 %.
  static constexpr double kTolerancePx = 1;
  static constexpr double kToleranceShare = 0.03;
};

// In how many rows a depth stands.
int RowsOf(const cv::Mat1f& depth_m, float depth) {
  int rows = 0;
  for (int y = 0; y < depth_m.rows; ++y) {
    rows += std::find(depth_m[y], depth_m[y] + depth_m.cols, depth) != depth_m[y] + depth_m.cols;
  }
  return rows;
}

RepeatedRange LargestOf(const TofImage& tof) {
  RepeatedRange found;
  for (const float depth_m : tof.depth_m) {
    if (!IsReturn(depth_m) || depth_m < found.depth_m) {
      if (IsReturn(depth_m)) found.next_m = std::max(found.next_m, depth_m);
    } else if (depth_m == found.depth_m) {
      ++found.count;
    } else {
      found.next_m = found.depth_m;
      found.depth_m = depth_m;
      found.count = 1;
    }
  }
  const double fewest = std::max<double>(
      RepeatedRules::kFewest, RepeatedRules::kShare * static_cast<double>(tof.depth_m.total()));
  const bool is_repeated = found.count >= fewest && found.next_m > 0 &&
                           found.depth_m >= RepeatedRules::kGap * found.next_m &&
                           RowsOf(tof.depth_m, found.depth_m) >= RepeatedRules::kRows;
  return is_repeated ? found : RepeatedRange{};
}

}  // namespace

RepeatedRange FindRepeatedRange(const std::vector<Match>& matches, const TofImage& tof,
                                const TofProjector& projector) {
  RepeatedRange found = LargestOf(tof);
  if (found.depth_m == 0) return found;
  const Rig& rig = projector.rig();
  const RectifiedPair& pair = rig.pair;
  // Disparities of its points, by cells.
  cv::Mat1f cells(pair.height / RepeatedRules::kCellPx + 1, pair.width / RepeatedRules::kCellPx + 1,
                  0.0F);
  const Eigen::Matrix3d rotation = rig.tof.left_from_tof_rotation.toRotationMatrix();
  for (int y = 0; y < tof.depth_m.rows; ++y) {
    for (int x = 0; x < tof.depth_m.cols; ++x) {
      if (tof.depth_m(y, x) != found.depth_m) continue;
      const Eigen::Vector3d point =
          rotation * (projector.ray(x, y) * found.depth_m) + rig.tof.left_from_tof_translation_m;
      if (!(point.z() > 0)) continue;
      const double share = pair.focal_px / point.z();
      const double u = share * point.x() + pair.cx;
      const double v = share * point.y() + pair.cy;
      if (!(u >= 0 && u < pair.width && v >= 0 && v < pair.height)) continue;
      cells(static_cast<int>(v) / RepeatedRules::kCellPx,
            static_cast<int>(u) / RepeatedRules::kCellPx) =
          static_cast<float>(share * pair.baseline_m);
    }
  }
  for (const Match& match : matches) {
    const float range = cells(static_cast<int>(match.left.y) / RepeatedRules::kCellPx,
                              static_cast<int>(match.left.x) / RepeatedRules::kCellPx);
    if (range <= 0) continue;
    const double stereo = match.disparity() + pair.cx_right - pair.cx;
    ++found.compared;
    const double allowed = RepeatedRules::kTolerancePx + RepeatedRules::kToleranceShare * range;
    if (std::abs(stereo - range) <= allowed) ++found.agreeing;
  }
  return found;
}

}  // namespace sprout::inputs
