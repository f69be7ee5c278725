#include "common/inputs/repeated_range.h"

#include <algorithm>

namespace sprout::inputs {
namespace {

struct RepeatedRules {
  static constexpr int kFewest = 20;
  static constexpr double kShare = 0.005;  ///< of the pixels
  /// Of the next smaller range: walls of one distance are not measured as one number, and numbers
  /// of a rounded depth lie nearer to each other.
  static constexpr double kGap = 1.25;
  static constexpr int kRows = 4;  ///< a beam of a lidar meets a flat road at one distance
};

// In how many rows a depth stands.
int RowsOf(const cv::Mat1f& depth_m, float depth) {
  int rows = 0;
  for (int y = 0; y < depth_m.rows; ++y) {
    rows += std::find(depth_m[y], depth_m[y] + depth_m.cols, depth) != depth_m[y] + depth_m.cols;
  }
  return rows;
}

}  // namespace

RepeatedRange FindRepeatedRange(const TofImage& tof) {
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

}  // namespace sprout::inputs
