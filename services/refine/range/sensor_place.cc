#include "services/refine/range/sensor_place.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "services/refine/range/range_rules.h"

namespace sprout::refine {
namespace {

// Disparities of points by their places in the left image.
class PointMap {
 public:
  PointMap(std::span<const ProjectedPoint> points, double agree_px, const cv::Size2d& spacing_px,
           const cv::Size& size)
      : agree_px_(static_cast<float>(agree_px)),
        wide_(std::max(1.0, spacing_px.width)),
        high_(std::max(1.0, spacing_px.height)),
        map_(static_cast<int>(size.height / high_) + 1, static_cast<int>(size.width / wide_) + 1,
             kNothing) {
    for (const ProjectedPoint& point : points) {
      const cv::Point cell = CellOf({point.seed.u, point.seed.v});
      if (!IsIn(cell)) continue;
      map_(cell) = std::max(map_(cell), point.seed.disparity());
    }
  }

  // What the points say of a match when all are moved.
  enum class Vote { kNone, kAgrees, kDisagrees };
  Vote Ask(const Seed& match, const cv::Point2d& move_px) const {
    const cv::Point cell = CellOf({match.u - move_px.x, match.v - move_px.y});
    const float here = IsIn(cell) ? map_(cell) : kNothing;
    if (here == kNothing) return Vote::kNone;
    return std::abs(here - match.disparity()) <= agree_px_ ? Vote::kAgrees : Vote::kDisagrees;
  }

 private:
  static constexpr float kNothing = std::numeric_limits<float>::lowest();

  cv::Point CellOf(const cv::Point2d& at) const {
    return {cvFloor(at.x / wide_), cvFloor(at.y / high_)};  // inline, unlike std::floor()
  }
  bool IsIn(const cv::Point& cell) const { return cv::Rect({}, map_.size()).contains(cell); }

  float agree_px_;
  double wide_, high_;
  cv::Mat1f map_;
};

// How many of the matches the points say something of, and how many agree.
struct Count {
  size_t compared = 0;
  size_t agreeing = 0;

  void Add(PointMap::Vote vote) {
    if (vote == PointMap::Vote::kNone) return;
    ++compared;
    if (vote == PointMap::Vote::kAgrees) ++agreeing;
  }
  double share() const {
    return compared == 0 ? 0 : static_cast<double>(agreeing) / static_cast<double>(compared);
  }
};

// The move at which most of the matches agree: of a grid over all moves, then of finer ones.
cv::Point2d BestMove(const PointMap& map, std::span<const Seed> matches, int width) {
  const size_t step = matches.size() / RangeRules::kMostMatches + 1;
  const auto asked = static_cast<double>((matches.size() + step - 1) / step);
  // Stops where a share of `most` is out of reach.
  const auto count_at = [&](const cv::Point2d& move_px, double most) {
    const double most_against = (1 - most) * asked;
    Count count;
    for (size_t i = 0; i < matches.size(); i += step) {
      count.Add(map.Ask(matches[i], move_px));
      if (static_cast<double>(count.compared - count.agreeing) > most_against) break;
    }
    return count;
  };
  constexpr double kNoShare = -1;
  const size_t fewest = count_at({}, kNoShare).compared / 2;
  cv::Point2d best;
  double most = kNoShare;
  // By value: `best` changes meanwhile.
  const auto look_around = [&](const cv::Point2d from, double step_px, int reach) {
    for (int y = -reach; y <= reach; ++y) {
      for (int x = -reach; x <= reach; ++x) {
        const cv::Point2d move_px = from + step_px * cv::Point2d(x, y);
        const Count count = count_at(move_px, most);
        if (count.compared < fewest || count.share() <= most) continue;
        most = count.share();
        best = move_px;
      }
    }
  };
  double step_px = RangeRules::kMaxDisplacement * width / RangeRules::kMoveSteps;
  look_around({}, step_px, RangeRules::kMoveSteps);
  for (int i = 0; i < RangeRules::kMoveRounds; ++i) look_around(best, step_px /= 2, 1);
  return best;
}

}  // namespace

SensorPlace FindSensorPlace(const PlacedPoints& points, std::span<const Seed> matches,
                            double agree_px, double strictness) {
  SensorPlace place;
  const PointMap raw(points.raw, agree_px, points.spacing_px, points.image);
  const PointMap corrected(points.corrected, agree_px, points.spacing_px, points.image);
  place.move_px = BestMove(raw, matches, points.image.width);
  // Matches side by side err together, so blocks of them are counted.
  constexpr int kBlocks = RangeRules::kMoveBlocks;
  cv::Mat1d gains(kBlocks, kBlocks, 0.0);
  Count as_is, moved;
  for (const Seed& match : matches) {
    const PointMap::Vote here = corrected.Ask(match, {});
    const PointMap::Vote there = raw.Ask(match, place.move_px);
    if (here == PointMap::Vote::kNone || there == PointMap::Vote::kNone) continue;
    as_is.Add(here);
    moved.Add(there);
    if (here == there) continue;
    const cv::Point block(static_cast<int>(match.u) * kBlocks / points.image.width,
                          static_cast<int>(match.v) * kBlocks / points.image.height);
    gains(block) += there == PointMap::Vote::kAgrees ? 1 : -1;
  }
  place.agree_as_is = as_is.share();
  place.agree_moved = moved.share();
  const double sigma = cv::norm(gains);
  if (sigma > 0) place.gain_sigmas = cv::sum(gains)[0] / sigma;
  // Where stereo itself errs less, so many are enough: what does not agree anywhere is its errors.
  const double enough = std::min(RangeRules::kMoveGain, 1 - place.agree_moved);
  place.is_displaced = as_is.compared >= RangeRules::kFewestCompared &&
                       place.agree_moved > RangeRules::kMoveFits &&
                       place.gain_sigmas > strictness * RangeRules::kMoveSigmas &&
                       place.agree_moved - place.agree_as_is > strictness * enough;
  return place;
}

}  // namespace sprout::refine
