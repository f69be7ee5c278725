#include "services/prior/delaunay.h"

#include <CGAL/Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>

#include <algorithm>
#include <utility>

namespace sprout {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using VertexBase = CGAL::Triangulation_vertex_base_with_info_2<int, Kernel>;
using Structure = CGAL::Triangulation_data_structure_2<VertexBase>;
using Delaunay = CGAL::Delaunay_triangulation_2<Kernel, Structure>;

}  // namespace

std::vector<SeedTriangle> TriangulateSeeds(std::span<const Seed> seeds) {
  std::vector<std::pair<Kernel::Point_2, int>> points;
  points.reserve(seeds.size());
  for (size_t i = 0; i < seeds.size(); ++i) {
    points.emplace_back(Kernel::Point_2(seeds[i].u, seeds[i].v), static_cast<int>(i));
  }
  // The first seed of each position, in an order that does not depend on the seeds' order.
  std::sort(points.begin(), points.end());
  points.erase(std::unique(points.begin(), points.end(),
                           [](const auto& a, const auto& b) { return a.first == b.first; }),
               points.end());
  // CGAL sorts along a space-filling curve, with a shuffle from a fixed start: repeatable.
  const Delaunay delaunay(points.begin(), points.end());

  std::vector<SeedTriangle> triangles;
  triangles.reserve(delaunay.number_of_faces());
  for (const auto face : delaunay.finite_face_handles()) {
    triangles.push_back(
        {face->vertex(0)->info(), face->vertex(1)->info(), face->vertex(2)->info()});
  }
  return triangles;
}

}  // namespace sprout
