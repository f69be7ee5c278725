#include "services/prior/triangulation.h"

#include <CGAL/Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>

#include <algorithm>
#include <numeric>
#include <tuple>
#include <utility>

namespace sprout::prior {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using VertexBase = CGAL::Triangulation_vertex_base_with_info_2<int, Kernel>;
using Delaunay =
    CGAL::Delaunay_triangulation_2<Kernel, CGAL::Triangulation_data_structure_2<VertexBase>>;

constexpr int kInfinite = -1;  // in place of a seed: what lies beyond the hull

// The first seed of each position, by rows and columns. Results are told in this order, so that
// they do not depend on the order of the seeds, nor on how CGAL inserts them.
std::vector<int> FirstOfEachPosition(std::span<const Seed> seeds) {
  const auto seed = [&](int i) -> const Seed& { return seeds[static_cast<size_t>(i)]; };
  std::vector<int> order(seeds.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](int a, int b) {
    return std::tie(seed(a).v, seed(a).u, a) < std::tie(seed(b).v, seed(b).u, b);
  });
  const auto same = [&](int a, int b) { return seed(a).u == seed(b).u && seed(a).v == seed(b).v; };
  order.erase(std::unique(order.begin(), order.end(), same), order.end());
  return order;
}

// The places around a vertex, counter-clockwise, from the least one on: kInfinite if it is there.
void PlacesAround(const Delaunay& delaunay, Delaunay::Vertex_handle vertex,
                  std::vector<int>& places) {
  places.clear();
  const auto first = delaunay.incident_vertices(vertex);
  auto around = first;
  do places.push_back(delaunay.is_infinite(around) ? kInfinite : around->info());
  while (++around != first);
  std::rotate(places.begin(), std::min_element(places.begin(), places.end()), places.end());
}

// False for nearly collinear seeds, whose area is lost in rounding.
bool HasArea(const Seed& a, const Seed& b, const Seed& c) {
  return (double{b.u} - a.u) * (double{c.v} - a.v) > (double{b.v} - a.v) * (double{c.u} - a.u);
}

}  // namespace

Triangulation Triangulate(std::span<const Seed> seeds) {
  Triangulation result;
  result.lists.resize(seeds.size());
  const std::vector<int> order = FirstOfEachPosition(seeds);  // by place
  const auto seed = [&](int place) { return order[static_cast<size_t>(place)]; };
  std::vector<std::pair<Kernel::Point_2, int>> points;
  points.reserve(order.size());
  for (int i : order) {
    const Seed& at = seeds[static_cast<size_t>(i)];
    points.emplace_back(Kernel::Point_2(at.u, at.v), static_cast<int>(points.size()));
  }
  Delaunay delaunay;
  delaunay.insert(points.begin(), points.end());  // sorts them along a space-filling curve
  if (delaunay.dimension() < 2) return result;
  std::vector<Delaunay::Vertex_handle> vertices(order.size());
  for (const auto vertex : delaunay.finite_vertex_handles()) {
    vertices[static_cast<size_t>(vertex->info())] = vertex;
  }
  std::vector<int> around;
  for (size_t i = 0; i < order.size(); ++i) {
    const auto place = static_cast<int>(i);
    PlacesAround(delaunay, vertices[i], around);
    Triangulation::List& list = result.lists[static_cast<size_t>(order[i])];
    list.begin = result.neighbours.size();
    for (size_t k = 0; k < around.size(); ++k) {
      const int one = around[k];
      const int next = around[(k + 1) % around.size()];
      if (one != kInfinite) result.neighbours.push_back(seed(one));
      if (one < place || next < place) continue;  // a triangle is told by its first corner
      const SeedTriangle triangle{order[i], seed(one), seed(next)};
      const auto corner = [&](size_t n) { return seeds[static_cast<size_t>(triangle[n])]; };
      if (HasArea(corner(0), corner(1), corner(2))) result.triangles.push_back(triangle);
    }
    list.size = result.neighbours.size() - list.begin;
  }
  PlacesAround(delaunay, delaunay.infinite_vertex(), around);
  for (auto place = around.rbegin(); place != around.rend(); ++place) {
    result.hull.push_back(seed(*place));
  }
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
