#include "services/refine/range/sensor_place.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/core/window_sums.h"
#include "services/refine/range/range_rules.h"

namespace sprout::refine {
namespace {

// A place where all points may belong instead, as in SensorPlace.
struct Placement {
  cv::Point2d move_px;
  double spread = 1;
  double scale = 1;
  double shear = 0;
  bool in_right_image = false;
};

// Disparities by their places in the left image: of points, or of matches if points are asked for.
class PlaceMap {
 public:
  PlaceMap(const PlacedPoints& all, cv::Size2d cell_px, double agree_px)
      : agree_px_(agree_px),
        infinity_px_(all.infinity_px),
        centre_(all.image.width / 2.0, all.image.height / 2.0),
        wide_(std::max(1.0, cell_px.width)),
        high_(std::max(1.0, cell_px.height)),
        map_(static_cast<int>(all.image.height / high_) + 1,
             static_cast<int>(all.image.width / wide_) + 1, kNothing) {}

  void Put(const Seed& seed) {
    const cv::Point cell = CellOf({seed.u, seed.v});
    if (IsIn(cell)) map_(cell) = std::max(map_(cell), seed.disparity());
  }

  // Compares a match with the map after all that this holds was scaled, spread, moved and sheared.
  enum class Vote { kNone, kAgrees, kDisagrees };
  Vote Compare(const Seed& match, const Placement& where) const {
    cv::Point2d there(match.u - where.shear * (match.v - centre_.y), match.v);
    if (where.in_right_image) there.x += match.disparity();
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

  void Add(PlaceMap::Vote vote) {
    if (vote == PlaceMap::Vote::kNone) return;
    ++compared;
    if (vote == PlaceMap::Vote::kAgrees) ++agreeing;
  }
  double share() const {
    return compared == 0 ? 0 : static_cast<double>(agreeing) / static_cast<double>(compared);
  }
};

// Finds where most of the matches agree with the points.
class PlaceSearch {
 public:
  PlaceSearch(const PlaceMap& map, std::span<const Seed> matches)
      : map_(map),
        matches_(matches),
        step_(matches.size() / RangeRules::kMaxMatches + 1),
        asked_(static_cast<double>((matches.size() + step_ - 1) / step_)),
        fewest_(CountAt({}).compared / 2) {}

  // The best of a grid over all moves, then of finer ones around it.
  Placement BestMove(int width, int steps_down = RangeRules::kMoveSteps) {
    most_ = kNoShare;
    double step_px = RangeRules::kMaxDisplacement * width / RangeRules::kMoveSteps;
    TryAround({}, step_px, {RangeRules::kMoveSteps, steps_down});
    for (int i = 0; i < RangeRules::kMoveRounds; ++i) TryAround(best_, step_px /= 2, {1, 1});
    return best_;
  }

  // The best of wider and narrower fields of view, then of finer steps around it.
  Placement BestSpread() {
    most_ = kNoShare;
    for (const double spread : RangeRules::kSpreads) Try({.move_px = {}, .spread = spread});
    double step = RangeRules::kSpreadStep;
    for (int i = 0; i < RangeRules::kMoveRounds; ++i, step /= 2) {
      const double from = best_.spread;  // `best_` changes meanwhile
      Try({.move_px = {}, .spread = from * (1 - step)});
      Try({.move_px = {}, .spread = from * (1 + step)});
    }
    return best_;
  }

  // The best shear of the rows.
  Placement BestShear() {
    most_ = kNoShare;
    for (int i = -RangeRules::kShearSteps; i <= RangeRules::kShearSteps; ++i) {
      Try({.move_px = {}, .shear = RangeRules::kShearStep * i});
    }
    return best_;
  }

  // The best factor of the ranges.
  Placement BestScale() {
    most_ = kNoShare;
    for (double scale = 1; scale < RangeRules::kMaxScale; scale *= 1 + RangeRules::kScaleStep) {
      Try({.move_px = {}, .spread = 1, .scale = scale});
      Try({.move_px = {}, .spread = 1, .scale = 1 / scale});
    }
    return best_;
  }

 private:
  static constexpr double kNoShare = -1;

  // Stops where a share of `most_` is out of reach.
  Count CountAt(const Placement& where) const {
    const double most_against = (1 - most_) * asked_;
    Count count;
    for (size_t i = 0; i < matches_.size(); i += step_) {
      count.Add(map_.Compare(matches_[i], where));
      if (static_cast<double>(count.compared - count.agreeing) > most_against) break;
    }
    return count;
  }

  void Try(const Placement& where) {
    const Count count = CountAt(where);
    if (count.compared < fewest_ || count.share() <= most_) return;
    most_ = count.share();
    best_ = where;
  }

  // By value: `best_` changes meanwhile.
  void TryAround(const Placement from, double step_px, const cv::Size& reach) {
    for (int y = -reach.height; y <= reach.height; ++y) {
      for (int x = -reach.width; x <= reach.width; ++x) {
        Try({.move_px = from.move_px + step_px * cv::Point2d(x, y)});
      }
    }
  }

  const PlaceMap& map_;
  std::span<const Seed> matches_;
  size_t step_;
  double asked_;
  double most_ = kNoShare;
  Placement best_;
  size_t fewest_;  // last: it is counted
};

// What a place must show to be believed.
struct Thresholds {
  double fits;  // least share of the matches that agrees there
  double gain;  // so many more are enough
  double strictness;
};

// A map, and what is compared with it.
struct MapQuery {
  const PlaceMap& map;
  std::span<const Seed> asked;
};

// Whether the points as measured fit better elsewhere than the corrected ones where they are.
// @param raw, corrected  have the same places or points in the same order.
SensorPlace Compare(const PlacedPoints& points, const MapQuery& raw, const MapQuery& corrected,
                    const Placement& elsewhere, const Thresholds& thresholds) {
  SensorPlace place{.move_px = elsewhere.move_px,
                    .spread = elsewhere.spread,
                    .scale = elsewhere.scale,
                    .shear = elsewhere.shear,
                    .in_right_image = elsewhere.in_right_image};
  // Matches side by side err together, so blocks of them are counted.
  constexpr int kBlocks = RangeRules::kMoveBlocks;
  cv::Mat1d gains(kBlocks, kBlocks, 0.0);
  Count as_is, moved;
  for (size_t i = 0; i < corrected.asked.size(); ++i) {
    const Seed& match = corrected.asked[i];
    const PlaceMap::Vote here = corrected.map.Compare(match, {});
    const PlaceMap::Vote there = raw.map.Compare(raw.asked[i], elsewhere);
    if (here == PlaceMap::Vote::kNone || there == PlaceMap::Vote::kNone) continue;
    as_is.Add(here);
    moved.Add(there);
    if (here == there) continue;
    const cv::Point block(static_cast<int>(match.u) * kBlocks / points.image.width,
                          static_cast<int>(match.v) * kBlocks / points.image.height);
    gains(block) += there == PlaceMap::Vote::kAgrees ? 1 : -1;
  }
  place.agree_as_is = as_is.share();
  place.agree_moved = moved.share();
  const double sigma = cv::norm(gains);
  if (sigma > 0) place.gain_sigmas = cv::sum(gains)[0] / sigma;
  // Half a pixel of the sensor does no harm.
  const double pixels = std::hypot(place.move_px.x / points.spacing_px.width,
                                   place.move_px.y / points.spacing_px.height);
  const bool is_far = !place.IsMove() || pixels >= 1;
  // Where stereo itself errs less, so many are enough: what does not agree anywhere is its errors.
  const double enough = std::min(thresholds.gain, 1 - place.agree_moved);
  place.is_displaced = is_far && as_is.compared >= RangeRules::kMinCompared &&
                       place.agree_moved > thresholds.fits &&
                       place.gain_sigmas > thresholds.strictness * RangeRules::kMoveSigmas &&
                       place.agree_moved - place.agree_as_is > thresholds.strictness * enough;
  return place;
}

// The better one: of two that are alike in whether they are believed, where more agree.
const SensorPlace& Better(const SensorPlace& one, const SensorPlace& other) {
  if (one.is_displaced != other.is_displaced) return one.is_displaced ? one : other;
  return other.agree_moved > one.agree_moved ? other : one;
}

}  // namespace

SensorPlace FindSensorPlace(const PlacedPoints& points, std::span<const Seed> matches,
                            double agree_px, double strictness) {
  PlaceMap raw(points, points.spacing_px, agree_px);
  PlaceMap corrected(points, points.spacing_px, agree_px);
  for (const ProjectedPoint& point : points.raw) raw.Put(point.seed);
  for (const ProjectedPoint& point : points.corrected) corrected.Put(point.seed);
  const Thresholds thresholds{RangeRules::kMoveFits, RangeRules::kMoveGain, strictness};
  PlaceSearch search(raw, matches);
  SensorPlace best;
  for (const Placement& elsewhere :
       {search.BestMove(points.image.width), search.BestSpread(), search.BestScale()}) {
    best =
        Better(best, Compare(points, {raw, matches}, {corrected, matches}, elsewhere, thresholds));
  }
  return best;
}

SensorPlace FindScanPlace(const PlacedPoints& points, std::span<const Seed> matches, double cell_px,
                          double agree_px, double strictness) {
  PlaceMap map(points, {cell_px, cell_px}, agree_px);
  for (const Seed& match : matches) map.Put(match);
  std::vector<Seed> raw, corrected;
  for (size_t i = 0; i < points.corrected.size(); ++i) {
    const Seed& seed = points.corrected[i].seed;
    if (!IsInside(seed.u, seed.v, points.image, 0)) continue;
    raw.push_back(points.raw[i].seed);
    corrected.push_back(seed);
  }
  const Thresholds thresholds{0, RangeRules::kScanMoveGain, strictness};
  PlaceSearch search(map, raw);
  const int steps_down = RangeRules::kMoveSteps * points.image.height / points.image.width;
  SensorPlace best;
  for (const Placement& elsewhere :
       {search.BestMove(points.image.width, steps_down), search.BestShear(),
        Placement{.move_px = {}, .in_right_image = true}}) {
    best = Better(best, Compare(points, {map, raw}, {map, corrected}, elsewhere, thresholds));
  }
  // So far they are what the matches would have to be moved by.
  best.move_px = -best.move_px;
  best.shear = -best.shear;
  return best;
}

}  // namespace sprout::refine
