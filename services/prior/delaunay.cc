#include "services/prior/delaunay.h"

#include <CGAL/Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>

#include <algorithm>
#include <boost/iterator/transform_iterator.hpp>
#include <tuple>
#include <utility>

namespace sprout {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using VertexBase = CGAL::Triangulation_vertex_base_with_info_2<int, Kernel>;
using Structure = CGAL::Triangulation_data_structure_2<VertexBase>;
using Delaunay = CGAL::Delaunay_triangulation_2<Kernel, Structure>;

}  // namespace

std::vector<SeedTriangle> TriangulateSeeds(std::span<const Seed> seeds) {
  return Triangulator().Triangulate(seeds);
}

const std::vector<SeedTriangle>& Triangulator::Triangulate(std::span<const Seed> seeds) {
  positions_.clear();
  positions_.reserve(seeds.size());
  for (const Seed& seed : seeds) {
    positions_.push_back({seed.u, seed.v, static_cast<int>(positions_.size())});
  }
  // The first seed of each position, in an order that does not depend on the seeds' order. Row by
  // row, as they often come.
  const auto before = [](const Position& a, const Position& b) {
    return std::tie(a.v, a.u, a.seed) < std::tie(b.v, b.u, b.seed);
  };
  if (!std::is_sorted(positions_.begin(), positions_.end(), before)) {
    std::sort(positions_.begin(), positions_.end(), before);
  }
  positions_.erase(
      std::unique(positions_.begin(), positions_.end(),
                  [](const Position& a, const Position& b) { return a.u == b.u && a.v == b.v; }),
      positions_.end());
  const auto point = [](const Position& at) {
    return std::pair(Kernel::Point_2(at.u, at.v), at.seed);
  };
  // CGAL sorts along a space-filling curve, with a shuffle from a fixed start: repeatable.
  const Delaunay delaunay(boost::make_transform_iterator(positions_.cbegin(), point),
                          boost::make_transform_iterator(positions_.cend(), point));

  triangles_.clear();
  triangles_.reserve(delaunay.number_of_faces());
  for (const auto face : delaunay.finite_face_handles()) {
    triangles_.push_back(
        {face->vertex(0)->info(), face->vertex(1)->info(), face->vertex(2)->info()});
  }
  return triangles_;
}

}  // namespace sprout
