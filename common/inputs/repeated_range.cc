#include "common/inputs/repeated_range.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace sprout::inputs {
namespace {

struct RepeatedRules {
  static constexpr int kMinPixels = 20;
  static constexpr double kShare = 0.005;   ///< of the pixels
  static constexpr double kMaxShare = 0.5;  ///< of the returns: more are the scene
  /// Smallest ratio to the next smaller range: a wall at one distance is not measured as one
  /// number, and rounded depths lie closer together.
  static constexpr double kGap = 1.25;
  /// Smallest ratio of its count to that of any range that is at most so much nearer or farther.
  static constexpr int kTimesBeside = 4;
  static constexpr float kBeside = 0.03F;
  static constexpr int kRows = 4;           ///< a beam of a lidar meets a flat road at one distance
  static constexpr size_t kValues = 20000;  ///< that are counted; more say no more
  /// Share of the matches that agrees with a wall: beyond everything else, and among it, where some
  /// agree by chance.
  static constexpr double kWallBeyond = 0.2;
  static constexpr double kWall = 0.5;
  static constexpr int kFewCompared = 25;
};

struct Run {
  float depth_m;
  int count;
};

// How often each of a part of the returns comes, in their order.
std::vector<Run> RunsOf(const cv::Mat1f& depth_m) {
  const size_t step = std::max<size_t>(1, depth_m.total() / RepeatedRules::kValues);
  std::vector<float> values;
  size_t i = 0;
  for (const float depth : depth_m) {
    if (i++ % step == 0 && IsReturn(depth)) values.push_back(depth);
  }
  std::ranges::sort(values);
  std::vector<Run> runs;
  for (const float depth : values) {
    if (runs.empty() || runs.back().depth_m != depth) runs.push_back({depth, 0});
    ++runs.back().count;
  }
  return runs;
}

// How often the most frequent range beside one comes; where ranges are coarse, the next one on
// either side counts.
int MostBeside(const std::vector<Run>& runs, size_t at) {
  const float reach = RepeatedRules::kBeside * runs[at].depth_m;
  int most = 0;
  for (size_t i = at; i-- > 0 && (i + 1 == at || runs[at].depth_m - runs[i].depth_m <= reach);) {
    most = std::max(most, runs[i].count);
  }
  for (size_t i = at + 1;
       i < runs.size() && (i == at + 1 || runs[i].depth_m - runs[at].depth_m <= reach); ++i) {
    most = std::max(most, runs[i].count);
  }
  return most;
}

// The number of rows that have a depth.
int RowsOf(const cv::Mat1f& depth_m, float depth) {
  int rows = 0;
  for (int y = 0; y < depth_m.rows; ++y) {
    rows += std::find(depth_m[y], depth_m[y] + depth_m.cols, depth) != depth_m[y] + depth_m.cols;
  }
  return rows;
}

bool AreWholeM(const std::vector<Run>& runs) {
  constexpr size_t kMinValues = 8;
  constexpr float kNearM = 30;  // there 1 m is 3 %
  int near = 0;
  int far = 0;
  for (const Run& run : runs) {
    if (run.depth_m != std::round(run.depth_m)) return false;
    (run.depth_m < kNearM ? near : far) += run.count;
  }
  return runs.size() >= kMinValues && near > far;
}

}  // namespace

bool RepeatedRange::MeansNothing() const {
  if (is_beyond) return agreeing <= RepeatedRules::kWallBeyond * compared;
  return compared >= RepeatedRules::kFewCompared && agreeing < RepeatedRules::kWall * compared;
}

RepeatedRange FindRepeatedRange(const TofImage& tof) {
  const std::vector<Run> runs = RunsOf(tof.depth_m);
  if (runs.size() < 2) return {};
  const auto last = runs.end() - 1;
  const bool is_beyond = last->depth_m >= RepeatedRules::kGap * (last - 1)->depth_m;
  const auto most = is_beyond ? last : std::ranges::max_element(runs, {}, &Run::count);
  const RepeatedRange found{.depth_m = most->depth_m,
                            .is_beyond = is_beyond,
                            .count = cv::countNonZero(tof.depth_m == most->depth_m),
                            .are_whole_m = AreWholeM(runs)};
  int returns = 0;
  for (const float depth : tof.depth_m) returns += IsReturn(depth) ? 1 : 0;
  const double fewest = std::max<double>(
      RepeatedRules::kMinPixels, RepeatedRules::kShare * static_cast<double>(tof.depth_m.total()));
  const int beside = MostBeside(runs, static_cast<size_t>(most - runs.begin()));
  const bool is_repeated = found.count >= fewest &&
                           found.count <= RepeatedRules::kMaxShare * returns &&
                           (is_beyond || most->count >= RepeatedRules::kTimesBeside * beside) &&
                           RowsOf(tof.depth_m, found.depth_m) >= RepeatedRules::kRows;
  return is_repeated ? found : RepeatedRange{.are_whole_m = found.are_whole_m};
}

}  // namespace sprout::inputs
