#include "services/refine/range/sensor_place.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "services/refine/range/range_rules.h"

namespace sprout::refine {
namespace {

// Where all points may belong instead, as in SensorPlace.
struct Elsewhere {
  cv::Point2d move_px;
  double spread = 1;
  double scale = 1;
};

// Disparities of points by their places in the left image.
class PointMap {
 public:
  PointMap(const PlacedPoints& all, std::span<const ProjectedPoint> points, double agree_px)
      : agree_px_(agree_px),
        infinity_px_(all.infinity_px),
        centre_(all.image.width / 2.0, all.image.height / 2.0),
        wide_(std::max(1.0, all.spacing_px.width)),
        high_(std::max(1.0, all.spacing_px.height)),
        map_(static_cast<int>(all.image.height / high_) + 1,
             static_cast<int>(all.image.width / wide_) + 1, kNothing) {
    for (const ProjectedPoint& point : points) {
      const cv::Point cell = CellOf({point.seed.u, point.seed.v});
      if (!IsIn(cell)) continue;
      map_(cell) = std::max(map_(cell), point.seed.disparity());
    }
  }

  // What the points say of a match when all are scaled, spread and moved.
  enum class Vote { kNone, kAgrees, kDisagrees };
  Vote Ask(const Seed& match, const Elsewhere& where) const {
    const cv::Point2d there(match.u, match.v);
    const cv::Point cell = CellOf(centre_ + (there - where.move_px - centre_) / where.spread);
    const float here = IsIn(cell) ? map_(cell) : kNothing;
    if (here == kNothing) return Vote::kNone;
    const double scaled = infinity_px_ + (here - infinity_px_) * where.scale;
    return std::abs(scaled - match.disparity()) <= agree_px_ ? Vote::kAgrees : Vote::kDisagrees;
  }

 private:
  static constexpr float kNothing = std::numeric_limits<float>::lowest();

  cv::Point CellOf(const cv::Point2d& at) const {
    return {cvFloor(at.x / wide_), cvFloor(at.y / high_)};  // inline, unlike std::floor()
  }
  bool IsIn(const cv::Point& cell) const { return cv::Rect({}, map_.size()).contains(cell); }

  double agree_px_, infinity_px_;
  cv::Point2d centre_;
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

// Finds where most of the matches agree with the points.
class PlaceSearch {
 public:
  PlaceSearch(const PointMap& map, std::span<const Seed> matches)
      : map_(map),
        matches_(matches),
        step_(matches.size() / RangeRules::kMostMatches + 1),
        asked_(static_cast<double>((matches.size() + step_ - 1) / step_)),
        fewest_(CountAt({}).compared / 2) {}

  // Of a grid over all moves, then of finer ones.
  Elsewhere BestMove(int width) {
    most_ = kNoShare;
    double step_px = RangeRules::kMaxDisplacement * width / RangeRules::kMoveSteps;
    LookAround({}, step_px, RangeRules::kMoveSteps);
    for (int i = 0; i < RangeRules::kMoveRounds; ++i) LookAround(best_, step_px /= 2, 1);
    return best_;
  }

  // Of wider and narrower fields of view, then of finer steps.
  Elsewhere BestSpread() {
    most_ = kNoShare;
    for (const double spread : RangeRules::kSpreads) LookAt({.move_px = {}, .spread = spread});
    double step = RangeRules::kSpreadStep;
    for (int i = 0; i < RangeRules::kMoveRounds; ++i, step /= 2) {
      const double from = best_.spread;  // `best_` changes meanwhile
      LookAt({.move_px = {}, .spread = from * (1 - step)});
      LookAt({.move_px = {}, .spread = from * (1 + step)});
    }
    return best_;
  }

  // Of shorter and longer ranges.
  Elsewhere BestScale() {
    most_ = kNoShare;
    for (double scale = 1; scale < RangeRules::kMaxScale; scale *= 1 + RangeRules::kScaleStep) {
      LookAt({.move_px = {}, .spread = 1, .scale = scale});
      LookAt({.move_px = {}, .spread = 1, .scale = 1 / scale});
    }
    return best_;
  }

 private:
  static constexpr double kNoShare = -1;

  // Stops where a share of `most_` is out of reach.
  Count CountAt(const Elsewhere& where) const {
    const double most_against = (1 - most_) * asked_;
    Count count;
    for (size_t i = 0; i < matches_.size(); i += step_) {
      count.Add(map_.Ask(matches_[i], where));
      if (static_cast<double>(count.compared - count.agreeing) > most_against) break;
    }
    return count;
  }

  void LookAt(const Elsewhere& where) {
    const Count count = CountAt(where);
    if (count.compared < fewest_ || count.share() <= most_) return;
    most_ = count.share();
    best_ = where;
  }

  // By value: `best_` changes meanwhile.
  void LookAround(const Elsewhere from, double step_px, int reach) {
    for (int y = -reach; y <= reach; ++y) {
      for (int x = -reach; x <= reach; ++x) {
        LookAt({.move_px = from.move_px + step_px * cv::Point2d(x, y)});
      }
    }
  }

  const PointMap& map_;
  std::span<const Seed> matches_;
  size_t step_;
  double asked_;
  double most_ = kNoShare;
  Elsewhere best_;
  size_t fewest_;  // last: it is counted
};

// Whether the points as measured fit better elsewhere than the corrected ones where they are.
SensorPlace Compare(const PlacedPoints& points, const PointMap& raw, const PointMap& corrected,
                    std::span<const Seed> matches, const Elsewhere& elsewhere, double strictness) {
  SensorPlace place{
      .move_px = elsewhere.move_px, .spread = elsewhere.spread, .scale = elsewhere.scale};
  // Matches side by side err together, so blocks of them are counted.
  constexpr int kBlocks = RangeRules::kMoveBlocks;
  cv::Mat1d gains(kBlocks, kBlocks, 0.0);
  Count as_is, moved;
  for (const Seed& match : matches) {
    const PointMap::Vote here = corrected.Ask(match, {});
    const PointMap::Vote there = raw.Ask(match, elsewhere);
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
  // Half a pixel of the sensor does no harm.
  const double pixels = std::hypot(place.move_px.x / points.spacing_px.width,
                                   place.move_px.y / points.spacing_px.height);
  const bool is_far = place.spread != 1 || place.scale != 1 || pixels >= 1;
  // Where stereo itself errs less, so many are enough: what does not agree anywhere is its errors.
  const double enough = std::min(RangeRules::kMoveGain, 1 - place.agree_moved);
  place.is_displaced = is_far && as_is.compared >= RangeRules::kFewestCompared &&
                       place.agree_moved > RangeRules::kMoveFits &&
                       place.gain_sigmas > strictness * RangeRules::kMoveSigmas &&
                       place.agree_moved - place.agree_as_is > strictness * enough;
  return place;
}

}  // namespace

SensorPlace FindSensorPlace(const PlacedPoints& points, std::span<const Seed> matches,
                            double agree_px, double strictness) {
  const PointMap raw(points, points.raw, agree_px);
  const PointMap corrected(points, points.corrected, agree_px);
  PlaceSearch search(raw, matches);
  SensorPlace best;
  for (const Elsewhere& elsewhere :
       {search.BestMove(points.image.width), search.BestSpread(), search.BestScale()}) {
    const SensorPlace place = Compare(points, raw, corrected, matches, elsewhere, strictness);
    const bool is_better = place.is_displaced == best.is_displaced
                               ? place.agree_moved > best.agree_moved
                               : place.is_displaced;
    if (is_better) best = place;
  }
  return best;
}

}  // namespace sprout::refine
