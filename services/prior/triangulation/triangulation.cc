#include "services/prior/triangulation/triangulation.h"

#include <CGAL/Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_face_base_with_info_2.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>

#include <algorithm>
#include <numeric>
#include <tuple>
#include <utility>

#include "common/core/parallel.h"
#include "services/prior/triangulation/grid_cells.h"

namespace sprout::prior {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using VertexBase = CGAL::Triangulation_vertex_base_with_info_2<int, Kernel>;
using FaceBase = CGAL::Triangulation_face_base_with_info_2<bool, Kernel>;
using Delaunay =
    CGAL::Delaunay_triangulation_2<Kernel,
                                   CGAL::Triangulation_data_structure_2<VertexBase, FaceBase>>;

constexpr int kInfinite = -1;  // in place of a seed: what lies beyond the hull

using FanTriangle = GridCells::FanTriangle;

// The first seed of each position, by rows and columns. Results are told in this order, so that
// they do not depend on the order of the seeds, nor on how triangles are found. O(n) where the
// seeds come row by row, as those of a ToF image nearly do.
std::vector<int> FirstOfEachPosition(std::span<const Seed> seeds) {
  constexpr float kRows = 1 << 14;  // of an image at most; those beyond share the first or last
  const auto seed = [&](int i) -> const Seed& { return seeds[static_cast<size_t>(i)]; };
  const auto row = [&](const Seed& at) {
    return static_cast<size_t>(std::clamp(at.v + 1, 0.F, kRows));
  };
  std::vector<int> first(static_cast<size_t>(kRows) + 3, 0);
  for (const Seed& at : seeds) ++first[row(at) + 2];
  std::partial_sum(first.begin(), first.end(), first.begin());
  std::vector<int> order(seeds.size());
  for (size_t i = 0; i < seeds.size(); ++i) {  // moves first[row + 1] to the row's end
    order[static_cast<size_t>(first[row(seeds[i]) + 1]++)] = static_cast<int>(i);
  }
  const auto before = [&](int a, int b) {
    return std::tie(seed(a).v, seed(a).u, a) < std::tie(seed(b).v, seed(b).u, b);
  };
  for (size_t k = 0; k + 1 < first.size(); ++k) {
    const auto begin = order.begin() + first[k];
    const auto end = order.begin() + first[k + 1];
    if (!std::is_sorted(begin, end, before)) std::sort(begin, end, before);
  }
  const auto same = [&](int a, int b) { return seed(a).u == seed(b).u && seed(a).v == seed(b).v; };
  order.erase(std::unique(order.begin(), order.end(), same), order.end());
  return order;
}

// Triangles that are not in intact cells, by CGAL: those between the points that are not inside of
// such cells. They fill what the cells leave out of the hull: the circles of the triangles there
// are empty of all points, so of these, too.
class TrianglesBetween {
 public:
  TrianglesBetween(std::span<const GridPoint> points, const GridCells& cells) : cells_(cells) {
    std::vector<std::pair<Kernel::Point_2, int>> outside;
    for (size_t i = 0; i < points.size(); ++i) {
      const auto place = static_cast<int>(i);
      if (cells.IsInside(place)) continue;
      outside.emplace_back(Kernel::Point_2(points[i].u, points[i].v), place);
    }
    // CGAL looks through all points of a line for each one that it adds: three that span a triangle
    // come first, and where there are none nothing is to be found.
    const auto third = ThirdOfTriangle(outside);
    if (third != outside.end()) {
      for (const auto& [point, place] : {outside[0], outside[1], *third}) {
        delaunay_.insert(point)->info() = place;
      }
      // Sorted along a space-filling curve.
      delaunay_.insert(outside.begin(), outside.end());
    }
    if (delaunay_.dimension() == 2) FindFaces();
    SortByPlace(points.size());
  }

  // The triangles at a point.
  std::span<const FanTriangle> FanAt(int place) const {
    const auto at = static_cast<size_t>(place);
    return std::span(fans_).subspan(first_[at], first_[at + 1] - first_[at]);
  }

 private:
  using Outside = std::vector<std::pair<Kernel::Point_2, int>>;

  // The first point off the line through the first two, exactly.
  static Outside::const_iterator ThirdOfTriangle(const Outside& outside) {
    if (outside.size() < 3) return outside.end();
    return std::find_if(outside.begin() + 2, outside.end(), [&](const auto& point) {
      return !CGAL::collinear(outside[0].first, outside[1].first, point.first);
    });
  }

  // Starts at the border of the intact cells; CGAL's faces on the cells themselves are others.
  void FindFaces() {
    std::vector<Delaunay::Face_handle> found;
    const auto find = [&](Delaunay::Face_handle face) {
      if (delaunay_.is_infinite(face) || face->info()) return;
      face->info() = true;
      found.push_back(face);
    };
    for (const auto face : delaunay_.all_face_handles()) face->info() = false;
    for (const auto face : delaunay_.finite_face_handles()) {
      if (!cells_.AnyIntact() || IsBesideCell(face)) find(face);
    }
    for (size_t i = 0; i < found.size(); ++i) {
      const Delaunay::Face_handle face = found[i];
      const auto place = [&](int corner) { return face->vertex(corner)->info(); };
      triangles_.push_back({place(0), place(1), place(2)});
      if (!cells_.AnyIntact()) continue;
      for (int k = 0; k < 3; ++k) {
        const bool borders_cell = cells_.HasTriangle(place((k + 2) % 3), place((k + 1) % 3));
        if (!borders_cell) find(face->neighbor(k));
      }
    }
  }

  bool IsBesideCell(Delaunay::Face_handle face) const {
    bool beside = false;
    for (int k = 0; k < 3; ++k) {
      const int from = face->vertex((k + 1) % 3)->info();
      const int to = face->vertex((k + 2) % 3)->info();
      if (cells_.HasTriangle(from, to)) return false;  // on it
      beside = beside || cells_.HasTriangle(to, from);
    }
    return beside;
  }

  void SortByPlace(size_t places) {
    first_.assign(places + 2, 0);
    for (const SeedTriangle& triangle : triangles_) {
      for (int place : triangle) ++first_[static_cast<size_t>(place) + 2];
    }
    std::partial_sum(first_.begin(), first_.end(), first_.begin());
    fans_.resize(3 * triangles_.size());
    for (const auto& [a, b, c] : triangles_) {
      const auto add = [&](int place, FanTriangle triangle) {
        fans_[first_[static_cast<size_t>(place) + 1]++] = triangle;
      };
      add(a, {b, c});
      add(b, {c, a});
      add(c, {a, b});
    }
    first_.pop_back();
  }

  const GridCells& cells_;
  Delaunay delaunay_;
  std::vector<SeedTriangle> triangles_;  // of places
  std::vector<size_t> first_;            // in fans_, of each place; one more than places
  std::vector<FanTriangle> fans_;
};

// The places around another, counter-clockwise, from the least one on: kInfinite if it is there.
// @param fan  all triangles at that point, each once; their order is lost.
void PlacesAround(std::vector<FanTriangle>& fan, std::vector<int>& places) {
  places.clear();
  if (fan.empty()) return;
  const auto starting_from = [&](size_t begin, int place) {
    return std::find_if(fan.begin() + static_cast<std::ptrdiff_t>(begin), fan.end(),
                        [&](const FanTriangle& triangle) { return triangle.from == place; });
  };
  // On the hull the fan is open: it starts at the place to which no triangle leads. In a closed one
  // each place is the start of a triangle and the end of another.
  int ends = 0;
  for (const FanTriangle& triangle : fan) ends ^= triangle.from ^ triangle.to;
  for (size_t i = 0; ends != 0 && i < fan.size(); ++i) {
    const int from = fan[i].from;
    if (std::none_of(fan.begin(), fan.end(),
                     [&](const FanTriangle& triangle) { return triangle.to == from; })) {
      std::swap(fan[0], fan[i]);
      places.push_back(kInfinite);
      break;
    }
  }
  for (size_t i = 0; i < fan.size(); ++i) {
    places.push_back(fan[i].from);
    const auto next = starting_from(i + 1, fan[i].to);
    if (next == fan.end()) break;
    std::iter_swap(fan.begin() + static_cast<std::ptrdiff_t>(i) + 1, next);
  }
  if (places.front() == kInfinite) places.push_back(fan[places.size() - 2].to);
  std::rotate(places.begin(), std::min_element(places.begin(), places.end()), places.end());
}

// False for nearly collinear seeds, whose area is lost in rounding.
bool HasArea(const Seed& a, const Seed& b, const Seed& c) {
  return (double{b.u} - a.u) * (double{c.v} - a.v) > (double{b.v} - a.v) * (double{c.u} - a.u);
}

// Counter-clockwise, the least place last. @param next  place on the hull behind each place.
std::vector<int> HullOf(const std::vector<int>& next) {
  std::vector<int> hull;
  const auto on_hull = [](int place) { return place != kInfinite; };
  const auto least = std::find_if(next.begin(), next.end(), on_hull);
  if (least == next.end()) return hull;
  const auto last = static_cast<int>(least - next.begin());
  int place = last;
  do {
    place = next[static_cast<size_t>(place)];
    hull.push_back(place);
  } while (place != last);
  return hull;
}

// Places one behind the other, with what is found around them.
struct PlaceRange {
  size_t begin = 0, end = 0;
  std::vector<SeedTriangle> triangles;
  std::vector<int> neighbours;
};
constexpr size_t kPlaceRanges = 32;

}  // namespace

Triangulation Triangulate(std::span<const Seed> seeds) {
  Triangulation result;
  result.lists.resize(seeds.size());
  const std::vector<int> order = FirstOfEachPosition(seeds);  // by place
  const auto seed = [&](int place) { return order[static_cast<size_t>(place)]; };
  std::vector<GridPoint> points;
  points.reserve(order.size());
  for (int i : order) {
    const Seed& at = seeds[static_cast<size_t>(i)];
    points.push_back({at.u, at.v, at.tof_u, at.tof_v});
  }
  const GridCells cells(points);
  const TrianglesBetween between(points, cells);
  std::vector<int> next_on_hull(order.size(), kInfinite);
  std::array<PlaceRange, kPlaceRanges> ranges;
  ForEachParallel(kPlaceRanges, [&](size_t k) {
    PlaceRange& range = ranges[k];
    range.begin = order.size() * k / kPlaceRanges;
    range.end = order.size() * (k + 1) / kPlaceRanges;
    range.triangles.reserve(2 * (range.end - range.begin));
    range.neighbours.reserve(6 * (range.end - range.begin));
    std::vector<FanTriangle> fan;
    std::vector<int> around;
    for (size_t i = range.begin; i < range.end; ++i) {
      const auto place = static_cast<int>(i);
      const std::span<const FanTriangle> others = between.FanAt(place);
      fan.assign(others.begin(), others.end());
      cells.AddFan(place, fan);
      PlacesAround(fan, around);
      if (!around.empty() && around.front() == kInfinite) next_on_hull[i] = around[1];
      Triangulation::List& list = result.lists[static_cast<size_t>(order[i])];
      list.begin = range.neighbours.size();
      for (size_t j = 0; j < around.size(); ++j) {
        const int one = around[j];
        const int next = around[(j + 1) % around.size()];
        if (one != kInfinite) range.neighbours.push_back(seed(one));
        if (one < place || next < place) continue;  // a triangle is told by its first corner
        const SeedTriangle triangle{order[i], seed(one), seed(next)};
        const auto corner = [&](size_t n) { return seeds[static_cast<size_t>(triangle[n])]; };
        if (HasArea(corner(0), corner(1), corner(2))) range.triangles.push_back(triangle);
      }
      list.size = range.neighbours.size() - list.begin;
    }
  });
  result.triangles.reserve(2 * order.size());
  result.neighbours.reserve(6 * order.size());
  for (const PlaceRange& range : ranges) {
    for (size_t i = range.begin; i < range.end; ++i) {
      result.lists[static_cast<size_t>(order[i])].begin += result.neighbours.size();
    }
    result.triangles.insert(result.triangles.end(), range.triangles.begin(), range.triangles.end());
    result.neighbours.insert(result.neighbours.end(), range.neighbours.begin(),
                             range.neighbours.end());
  }
  for (int place : HullOf(next_on_hull)) result.hull.push_back(seed(place));
  return result;
}

std::span<const int> Rings::Around(std::span<const int> seeds, int rings, size_t most) {
  ++call_;
  found_.clear();
  for (int seed : seeds) {
    if (static_cast<size_t>(seed) < found_in_.size()) Add(seed);
  }
  size_t next = 0;
  for (int ring = 0; ring < rings; ++ring) {
    for (const size_t end = found_.size(); next < end; ++next) {
      for (int neighbour : triangulation_.NeighboursOf(found_[next])) {
        if (found_.size() >= most) return found_;
        Add(neighbour);
      }
    }
  }
  return found_;
}

void Rings::Add(int seed) {
  int& found_in = found_in_[static_cast<size_t>(seed)];
  if (std::exchange(found_in, call_) != call_) found_.push_back(seed);
}

}  // namespace sprout::prior
