#include "services/prior/edges/outline.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace sprout::prior {
namespace {

// The third corner of the triangle that lies inside of a side of the outline: the neighbours of a
// seed are in the order of the outline.
int ThirdCorner(const Triangulation& triangulation, int from, int to) {
  const std::span<const int> around = triangulation.NeighboursOf(from);
  const auto at = std::find(around.begin(), around.end(), to) - around.begin();
  return around[static_cast<size_t>(at + 1) % around.size()];
}

}  // namespace

void TakeOffFlatTriangles(std::span<const Seed> seeds, double longest_px, double deepest_px,
                          Triangulation& triangulation) {
  if (triangulation.hull.empty()) return;
  std::vector<uint8_t> on_outline(seeds.size(), 0);
  for (const int seed : triangulation.hull) on_outline[static_cast<size_t>(seed)] = 1;
  const auto is_flat = [&](int from, int to, int third) {
    const Seed& a = seeds[static_cast<size_t>(from)];
    const Seed& b = seeds[static_cast<size_t>(to)];
    const Seed& c = seeds[static_cast<size_t>(third)];
    const double u = double{b.u} - a.u;
    const double v = double{b.v} - a.v;
    const double length = std::sqrt(u * u + v * v);
    return length > longest_px && on_outline[static_cast<size_t>(third)] == 0 &&
           std::abs(u * (double{c.v} - a.v) - v * (double{c.u} - a.u)) < deepest_px * length;
  };
  // Seeds that are still to come, the next one last.
  std::vector<int> ahead(triangulation.hull.rbegin(), triangulation.hull.rend());
  ahead.insert(ahead.begin(), ahead.back());
  std::vector<int> outline{ahead.back()};
  ahead.pop_back();
  std::vector<SeedTriangle> flat;
  while (!ahead.empty()) {
    const int from = outline.back();
    const int to = ahead.back();
    const int third = ThirdCorner(triangulation, from, to);
    if (is_flat(from, to, third)) {
      flat.push_back({from, to, third});
      on_outline[static_cast<size_t>(third)] = 1;
      ahead.push_back(third);
    } else {
      outline.push_back(to);
      ahead.pop_back();
    }
  }
  outline.pop_back();  // the first one again
  triangulation.hull = outline;
  for (SeedTriangle& triangle : flat) std::sort(triangle.begin(), triangle.end());
  std::sort(flat.begin(), flat.end());
  std::erase_if(triangulation.triangles, [&](SeedTriangle triangle) {
    const auto& [a, b, c] = triangle;
    const auto is_on = [&](int seed) { return on_outline[static_cast<size_t>(seed)] != 0; };
    if (!is_on(a) || !is_on(b) || !is_on(c)) return false;
    std::sort(triangle.begin(), triangle.end());
    return std::binary_search(flat.begin(), flat.end(), triangle);
  });
}

}  // namespace sprout::prior
