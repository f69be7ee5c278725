#include "services/prior/delaunay_mesh.h"

#include <CGAL/Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Hilbert_policy_tags.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>
#include <CGAL/spatial_sort.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>

namespace sprout {
namespace {

// With so few bits in a coordinate the tests that decide on a triangulation have exact results in
// 128, and four positions on a circle, which a grid is full of, cost no more than others: 7 ms for
// 19,000 positions of a grid, CGAL's own kernel 10.
static_assert(DelaunayMesh::kFarthest <= 1 << 28);

using CgalKernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = CgalKernel::Point_2;

struct Offset {
  Offset(const Point& from, const Point& to)
      : u(static_cast<int64_t>(to.x() - from.x())), v(static_cast<int64_t>(to.y() - from.y())) {}
  int64_t u;
  int64_t v;
};

int64_t Cross(const Offset& a, const Offset& b) { return a.u * b.v - a.v * b.u; }

// a · (a − b)
int64_t DotDifference(const Offset& a, const Offset& b) {
  return a.u * (a.u - b.u) + a.v * (a.v - b.v);
}

struct WholeNumberKernel : CgalKernel {
  struct Orientation_2 {
    using result_type = CGAL::Orientation;
    result_type operator()(const Point& p, const Point& q, const Point& r) const {
      return CGAL::sign(Cross(Offset(p, q), Offset(p, r)));
    }
  };
  // Of the circle through p, q, r, counter-clockwise: t is inside where this is positive.
  struct Side_of_oriented_circle_2 {
    using result_type = CGAL::Oriented_side;
    result_type operator()(const Point& p, const Point& q, const Point& r, const Point& t) const {
      const Offset to_q(p, q), to_r(p, r), to_t(p, t);
      return CGAL::sign(__int128{Cross(to_q, to_t)} * DotDifference(to_r, to_q) -
                        __int128{Cross(to_q, to_r)} * DotDifference(to_t, to_q));
    }
  };
  Orientation_2 orientation_2_object() const { return {}; }
  Side_of_oriented_circle_2 side_of_oriented_circle_2_object() const { return {}; }
};

using VertexBase = CGAL::Triangulation_vertex_base_with_info_2<int, WholeNumberKernel>;
using Structure = CGAL::Triangulation_data_structure_2<VertexBase>;
using Delaunay = CGAL::Delaunay_triangulation_2<WholeNumberKernel, Structure>;
using Vertex = Delaunay::Vertex_handle;
using Face = Delaunay::Face_handle;

// CGAL's clear() gives the memory back. Backwards, because what is erased last is taken first: the
// next triangulation has its triangles in the same order as in new memory.
template <typename Elements>
void EraseAll(Elements& elements) {
  auto element = elements.end();
  while (!elements.empty()) elements.erase(--element);
}

// A triangulation of three vertices, counter-clockwise, in place of what was there.
Face StartWith(const std::array<Point, 3>& corners, Delaunay& delaunay) {
  Structure& structure = delaunay.tds();
  EraseAll(structure.faces());
  EraseAll(structure.vertices());
  structure.set_dimension(2);
  const Vertex infinite = structure.create_vertex();
  delaunay.set_infinite_vertex(infinite);
  std::array<Vertex, 3> vertex;
  for (size_t i = 0; i < 3; ++i) {
    vertex[i] = structure.create_vertex();
    vertex[i]->set_point(corners[i]);
  }
  const Face inside = structure.create_face(vertex[0], vertex[1], vertex[2]);
  std::array<Face, 3> outside;  // across the edge opposite of each vertex
  for (size_t i = 0; i < 3; ++i) {
    outside[i] = structure.create_face(vertex[(i + 2) % 3], vertex[(i + 1) % 3], infinite);
    structure.set_adjacency(inside, static_cast<int>(i), outside[i], 2);
    vertex[i]->set_face(inside);
  }
  for (size_t i = 0; i < 3; ++i) structure.set_adjacency(outside[i], 0, outside[(i + 2) % 3], 1);
  infinite->set_face(outside[0]);
  return inside;
}

}  // namespace

struct DelaunayMesh::Cgal {
  Delaunay delaunay;
};

// How CGAL sorts positions.
struct DelaunayMesh::SortTraits {
  using Point_2 = MeshPosition;
  struct Less_x_2 {
    bool operator()(const MeshPosition& a, const MeshPosition& b) const { return a.u < b.u; }
  };
  struct Less_y_2 {
    bool operator()(const MeshPosition& a, const MeshPosition& b) const { return a.v < b.v; }
  };
  struct Compute_x_2 {
    double operator()(const MeshPosition& at) const { return at.u; }
  };
  struct Compute_y_2 {
    double operator()(const MeshPosition& at) const { return at.v; }
  };
  Less_x_2 less_x_2_object() const { return {}; }
  Less_y_2 less_y_2_object() const { return {}; }
  Compute_x_2 compute_x_2_object() const { return {}; }
  Compute_y_2 compute_y_2_object() const { return {}; }
};

DelaunayMesh::DelaunayMesh() : cgal_(std::make_unique<Cgal>()) {}
DelaunayMesh::~DelaunayMesh() = default;

void DelaunayMesh::Triangulate(std::span<const MeshPosition> positions) {
  positions_.assign(positions.begin(), positions.end());
  triangles_.clear();
  hull_.clear();
  TakeCorners();
  if (corners_.size() < 3) {
    for (const MeshPosition& at : positions_) hull_.push_back(at.id);
    return;
  }
  Connect();
  const Delaunay& delaunay = cgal_->delaunay;
  triangles_.reserve(delaunay.number_of_faces());
  for (const auto face : delaunay.finite_face_handles()) {
    triangles_.push_back(
        {face->vertex(0)->info(), face->vertex(1)->info(), face->vertex(2)->info()});
  }
  const auto first = delaunay.incident_vertices(delaunay.infinite_vertex());
  auto vertex = first;
  do hull_.push_back(vertex->info());
  while (--vertex != first);
}

// The hull's corners first, of which each sees but one edge of those before it: a point that sees
// more makes CGAL allocate.
void DelaunayMesh::Connect() {
  Delaunay& delaunay = cgal_->delaunay;
  // Along a space-filling curve in rounds, with a shuffle from a fixed start: repeatable.
  const auto sort_in_rounds = [](std::vector<MeshPosition>& positions) {
    CGAL::spatial_sort(positions.begin(), positions.end(), SortTraits(),
                       CGAL::Hilbert_sort_middle_policy());
  };
  const auto point = [](const MeshPosition& at) { return Point(at.u, at.v); };
  sort_in_rounds(corners_);
  std::array<Point, 3> first{point(corners_[0]), point(corners_[1]), point(corners_[2])};
  if (WholeNumberKernel::Orientation_2()(first[0], first[1], first[2]) == CGAL::CLOCKWISE) {
    std::swap(first[1], first[2]);
  }
  Face near = StartWith(first, delaunay);
  const auto insert = [&](const std::vector<MeshPosition>& positions) {
    for (const MeshPosition& at : positions) {
      const Vertex vertex = delaunay.insert(point(at), near);
      vertex->info() = at.id;
      near = vertex->face();
    }
  };
  insert(corners_);
  sort_in_rounds(positions_);  // corners among them, which are found to be there
  insert(positions_);
}

// Of the convex hull, without positions on its edges; counter-clockwise in a frame with v upwards.
// Andrew's monotone chain, Information Processing Letters 9(5), 1979: along the sorted positions
// and back. Fewer than three where all positions are on a line.
void DelaunayMesh::TakeCorners() {
  corners_.clear();
  if (positions_.empty()) return;
  const auto extend = [&](const MeshPosition& at, size_t start) {
    const auto turns_left = [&] {
      const MeshPosition &a = corners_.end()[-2], &b = corners_.back();
      return int64_t{b.u - a.u} * (at.v - a.v) > int64_t{b.v - a.v} * (at.u - a.u);
    };
    while (corners_.size() >= start + 2 && !turns_left()) corners_.pop_back();
    corners_.push_back(at);
  };
  for (const MeshPosition& at : positions_) extend(at, 0);
  const size_t turn = corners_.size() - 1;
  for (size_t i = positions_.size() - 1; i > 0; --i) extend(positions_[i - 1], turn);
  corners_.pop_back();  // the first again
}

}  // namespace sprout
