#include "services/refine/range/contradiction.h"

#include <algorithm>
#include <cmath>

#include "services/refine/range/range_costs.h"
#include "services/refine/surface/surface_rules.h"
#include "services/refine/surface/tof_surface.h"

namespace sprout::refine {
namespace {

// How many matches agree with points or contradict them, and how far off they are.
struct MatchVotes {
  double agreeing = 0;
  double against = 0;
  // Sums of squared distances, of the variances that points and matches claim, and of those that
  // matches alone claim; 0 if these were not asked for.
  double off_px2 = 0;
  double claimed_px2 = 0;
  double of_matches_px2 = 0;

  bool none() const { return agreeing + against == 0; }
  void Add(const MatchVotes& others, double weight = 1) {
    agreeing += weight * others.agreeing;
    against += weight * others.against;
    off_px2 += weight * others.off_px2;
    claimed_px2 += weight * others.claimed_px2;
    of_matches_px2 += weight * others.of_matches_px2;
  }
};

// Points by the cells of a grid, one in each.
class CellIndex {
 public:
  explicit CellIndex(cv::Size size) : index_(size, -1) {}

  // Of two points in a cell the nearer one stays.
  void Put(const cv::Point& cell, std::span<const ProjectedPoint> points, size_t point) {
    if (!IsIn(cell)) return;
    int& known = index_(cell);
    const auto is_nearer = [&](size_t than) {
      return points[point].seed.disparity() > points[than].seed.disparity();
    };
    if (known < 0 || is_nearer(static_cast<size_t>(known))) known = static_cast<int>(point);
  }

  bool Has(const cv::Point& cell) const { return IsIn(cell) && index_(cell) >= 0; }
  size_t At(const cv::Point& cell) const { return static_cast<size_t>(index_(cell)); }

  // Calls visit(point) for the points in the cells around `cell`, itself included.
  template <typename Visit>
  void Around(const cv::Point& cell, int reach, const Visit& visit) const {
    const cv::Rect window = cv::Rect({}, index_.size()) &
                            cv::Rect(cell.x - reach, cell.y - reach, 2 * reach + 1, 2 * reach + 1);
    for (int y = window.y; y < window.y + window.height; ++y) {
      for (int x = window.x; x < window.x + window.width; ++x) {
        if (index_(y, x) >= 0) visit(static_cast<size_t>(index_(y, x)));
      }
    }
  }

 private:
  bool IsIn(const cv::Point& cell) const { return cv::Rect({}, index_.size()).contains(cell); }

  cv::Mat1i index_;
};

// The points as they lie in the range image.
CellIndex InRangeImage(std::span<const ProjectedPoint> points) {
  cv::Size size;
  for (const ProjectedPoint& point : points) {
    size.width = std::max(size.width, point.tof_u + 1);
    size.height = std::max(size.height, point.tof_v + 1);
  }
  CellIndex index(size);
  for (size_t i = 0; i < points.size(); ++i) {
    index.Put({points[i].tof_u, points[i].tof_v}, points, i);
  }
  return index;
}

cv::Point PixelOf(const ProjectedPoint& point) { return {point.tof_u, point.tof_v}; }

// Numbers the surfaces: points that steps of less than `step_px` connect.
std::vector<size_t> SurfacesOf(std::span<const ProjectedPoint> points, const CellIndex& pixels,
                               double step_px) {
  const size_t none = points.size();
  std::vector<size_t> surfaces(points.size(), none);
  std::vector<size_t> todo;
  for (size_t first = 0; first < points.size(); ++first) {
    if (surfaces[first] != none) continue;
    surfaces[first] = first;
    todo = {first};
    while (!todo.empty()) {
      const ProjectedPoint& point = points[todo.back()];
      todo.pop_back();
      pixels.Around(PixelOf(point), 1, [&](size_t other) {
        const double step = points[other].seed.disparity() - point.seed.disparity();
        if (surfaces[other] != none || std::abs(step) > step_px) return;
        surfaces[other] = first;
        todo.push_back(other);
      });
    }
  }
  return surfaces;
}

// Whether the images clearly prefer one disparity to another at a place.
bool Prefers(const cv::Mat1b& left, const cv::Mat1b& right, const Seed& place, double disparity,
             double to) {
  const auto difference = [&](double of) {
    return SurfaceRules::kNoise + WindowDifference(left, right, place.u, place.v, place.u - of);
  };
  return difference(to) > RangeRules::kBetterMatch * difference(disparity);
}

// Each match votes on the point that it lies at: it agrees with one of the points around, or is
// against it if the images prefer the match. Where they do not, stereo may err. The distance to the
// points' planes is taken at the middle of the match's cell.
std::vector<MatchVotes> VotesOf(const cv::Mat1b& left, const cv::Mat1b& right,
                                const PlacedPoints& points, std::span<const Seed> matches,
                                double agree_px, const CellGrid* cells_of_matches) {
  const std::span<const ProjectedPoint> all = points.corrected;
  PointSurface planes;
  std::vector<Seed> seeds;
  if (cells_of_matches != nullptr) {
    for (const ProjectedPoint& point : all) seeds.push_back(point.seed);
    planes.Set(seeds, *cells_of_matches);
  }
  const double wide = std::max(1.0, points.spacing_px.width);
  const double high = std::max(1.0, points.spacing_px.height);
  const auto cell_of = [&](const Seed& seed) {
    return cv::Point(cvFloor(seed.u / wide), cvFloor(seed.v / high));
  };
  CellIndex cells({static_cast<int>(left.cols / wide) + 1, static_cast<int>(left.rows / high) + 1});
  for (size_t i = 0; i < all.size(); ++i) cells.Put(cell_of(all[i].seed), all, i);
  std::vector<MatchVotes> votes(all.size());
  for (const Seed& match : matches) {
    const cv::Point cell = cell_of(match);
    if (!cells.Has(cell)) continue;
    size_t best = cells.At(cell);
    const auto off_px = [&](size_t point) {
      return std::abs(double{all[point].seed.disparity()} - match.disparity());
    };
    cells.Around(cell, 1, [&](size_t other) {
      if (off_px(other) < off_px(best)) best = other;
    });
    const bool agrees = off_px(best) <= agree_px;
    if (!agrees && !Prefers(left, right, match, match.disparity(), all[best].seed.disparity()))
      continue;
    MatchVotes vote{.agreeing = agrees ? 1.0 : 0.0, .against = agrees ? 0.0 : 1.0};
    const size_t of = agrees ? best : cells.At(cell);
    if (cells_of_matches != nullptr) {
      const cv::Point at(cells_of_matches->At(match.u), cells_of_matches->At(match.v));
      constexpr double kMaxPx = RangeRules::kAgreePx;  // so that stereo's mistakes do not rule
      const double off_plane_px = std::min(planes.OffPx(at, match.disparity()), kMaxPx);
      const double of_match_px = double{match.sigma_px};
      const double of_point_px = std::min(double{all[of].seed.sigma_px}, kMaxPx);
      vote.off_px2 = off_plane_px * off_plane_px;
      vote.of_matches_px2 = of_match_px * of_match_px;
      vote.claimed_px2 = vote.of_matches_px2 + of_point_px * of_point_px;
    }
    votes[of].Add(vote);
  }
  return votes;
}

// Whether a surface has too few votes to be contradicted: where there is no texture, or highlights,
// stereo has few matches, and these are wrong. Votes that are of one mind may be fewer.
bool IsSparse(const MatchVotes& votes, double usual) {
  const double count = votes.agreeing + votes.against;
  const double least = std::min(RangeRules::kMinVotes + votes.agreeing / std::max(1.0, count),
                                RangeRules::kMinMixedVotes);
  return count < least * usual;
}

// Of each point the votes around it on its surface, the nearest weighing most; where there are
// none, those of all of the surface. None where these are too few.
std::vector<MatchVotes> VotesAround(const PlacedPoints& points, std::span<const MatchVotes> votes) {
  const std::span<const ProjectedPoint> all = points.corrected;
  const CellIndex pixels = InRangeImage(all);
  const double spacing_px = std::max(points.spacing_px.width, points.spacing_px.height);
  const std::vector<size_t> surfaces = SurfacesOf(all, pixels, SurfaceRules::EdgePx(spacing_px));
  std::vector<MatchVotes> of_surface(all.size()), around(all.size());
  std::vector<double> sizes(all.size());
  double count = 0;
  for (size_t i = 0; i < all.size(); ++i) {
    of_surface[surfaces[i]].Add(votes[i]);
    ++sizes[surfaces[i]];
    count += votes[i].agreeing + votes[i].against;
  }
  const double votes_a_point = count / static_cast<double>(all.size());
  for (size_t i = 0; i < all.size(); ++i) {
    if (IsSparse(of_surface[surfaces[i]], votes_a_point * sizes[surfaces[i]])) continue;
    pixels.Around(PixelOf(all[i]), RangeRules::kVoteReach, [&](size_t other) {
      if (surfaces[other] != surfaces[i]) return;
      const cv::Point way = PixelOf(all[other]) - PixelOf(all[i]);
      around[i].Add(votes[other], 1 / (0.25 + way.dot(way)));
    });
    if (around[i].none()) around[i] = of_surface[surfaces[i]];
  }
  return around;
}

}  // namespace

Contradiction FindContradicted(const cv::Mat1b& left, const cv::Mat1b& right,
                               const PlacedPoints& points, std::span<const Seed> matches,
                               double agree_px, const CellGrid* cells_of_matches,
                               double unexplained) {
  const std::vector<MatchVotes> votes =
      VotesOf(left, right, points, matches, agree_px, cells_of_matches);
  MatchVotes sum;
  for (const MatchVotes& of_point : votes) sum.Add(of_point);
  Contradiction found;
  if (sum.none()) return found;
  found.share = sum.against / (sum.agreeing + sum.against);
  const bool differs = found.share > RangeRules::kDifferingShare;
  const bool claims_too_little = sum.off_px2 > unexplained * sum.claimed_px2;
  if (!differs && !claims_too_little) return found;
  for (const MatchVotes& here : VotesAround(points, votes)) {
    const double count = here.agreeing + here.against;
    if (differs) found.points.push_back(here.against > RangeRules::kAgainstShare * count ? 1 : 0);
    if (!claims_too_little) continue;
    const double off_px2 = std::max(0.0, here.off_px2 - here.of_matches_px2);
    found.sigma_px.push_back(count == 0 ? 0 : static_cast<float>(std::sqrt(off_px2 / count)));
  }
  return found;
}

double ShareAgainst(const cv::Mat1b& left, const cv::Mat1b& right,
                    std::span<const ProjectedPoint> points, std::span<const Seed> matches,
                    double reach_px) {
  cv::Mat1i cells(static_cast<int>(left.rows / reach_px) + 1,
                  static_cast<int>(left.cols / reach_px) + 1, -1);
  const cv::Rect all({}, cells.size());
  const auto cell_of = [&](const Seed& seed) {
    return cv::Point(cvFloor(seed.u / reach_px), cvFloor(seed.v / reach_px));
  };
  for (size_t i = 0; i < matches.size(); ++i) {
    const cv::Point cell = cell_of(matches[i]);
    if (all.contains(cell)) cells(cell) = static_cast<int>(i);
  }
  MatchVotes votes;
  for (const ProjectedPoint& point : points) {
    const Seed& seed = point.seed;
    const cv::Point cell = cell_of(seed);
    const cv::Rect around = all & cv::Rect(cell.x - 1, cell.y - 1, 3, 3);
    const Seed* nearest = nullptr;
    double distance_px = reach_px;
    bool agrees = false;
    for (int y = around.y; y < around.y + around.height; ++y) {
      for (int x = around.x; x < around.x + around.width; ++x) {
        if (cells(y, x) < 0) continue;
        const Seed& match = matches[static_cast<size_t>(cells(y, x))];
        const double off_px = std::hypot(match.u - seed.u, match.v - seed.v);
        if (off_px > reach_px) continue;
        agrees |= std::abs(match.disparity() - seed.disparity()) <= RangeRules::kAgreePx;
        if (off_px > distance_px) continue;
        distance_px = off_px;
        nearest = &match;
      }
    }
    if (agrees) {
      ++votes.agreeing;
    } else if (nearest != nullptr &&
               Prefers(left, right, seed, nearest->disparity(), seed.disparity()) &&
               IsAlike(left, right, *nearest, RangeRules::kUnlikeVariance)) {
      ++votes.against;
    }
  }
  const double asked = votes.agreeing + votes.against;
  return asked < RangeRules::kMinScanPoints ? 0 : votes.against / asked;
}

}  // namespace sprout::refine
