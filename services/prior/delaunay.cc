#include "services/prior/delaunay.h"

#include <cstddef>
#include <memory_resource>

namespace sprout {
namespace {

// CGAL takes memory in blocks and frees them with a triangulation. Freed ones wait here for the
// next.
std::pmr::memory_resource& BlocksOfCgal() {
  constexpr size_t kLargestBlock = size_t{1} << 20;
  static std::pmr::synchronized_pool_resource blocks(std::pmr::pool_options{
      .max_blocks_per_chunk = 0, .largest_required_pool_block = kLargestBlock});
  return blocks;
}

template <typename T>
struct BlockAllocator {
  using value_type = T;

  BlockAllocator() = default;
  template <typename U>
  explicit BlockAllocator(const BlockAllocator<U>&) {}

  T* allocate(size_t count) {
    return static_cast<T*>(BlocksOfCgal().allocate(count * sizeof(T), alignof(T)));
  }
  void deallocate(T* block, size_t count) {
    BlocksOfCgal().deallocate(block, count * sizeof(T), alignof(T));
  }
  bool operator==(const BlockAllocator&) const = default;
};

}  // namespace
}  // namespace sprout

#define CGAL_ALLOCATOR(T) sprout::BlockAllocator<T>  // CGAL's own hook, read by its headers
#include <CGAL/Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Hilbert_policy_tags.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>
#include <CGAL/spatial_sort.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <tuple>

namespace sprout {
namespace {

// Positions are whole numbers of this part of a pixel. With so few bits the tests that decide on a
// triangulation have exact results in 128, and four seeds on a circle, which a grid is full of,
// cost no more than others: 7 ms for 19,000 seeds of a grid, CGAL's own kernel 10.
constexpr float kStepsPerPixel = 64;
constexpr float kFarthest = 1 << 28;

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

// Not so for seeds so nearly on one line that only the rounding of their positions parts them.
bool HasArea(std::span<const Seed> seeds, const SeedTriangle& triangle) {
  const auto seed = [&](size_t i) -> const Seed& {
    return seeds[static_cast<size_t>(triangle[i])];
  };
  const double bu = double{seed(1).u} - seed(0).u, bv = double{seed(1).v} - seed(0).v;
  const double cu = double{seed(2).u} - seed(0).u, cv = double{seed(2).v} - seed(0).v;
  return bu * cv > bv * cu;
}

int Steps(float px) {
  return static_cast<int>(std::lround(std::clamp(px * kStepsPerPixel, -kFarthest, kFarthest)));
}

}  // namespace

// How CGAL sorts positions.
struct Triangulator::SortTraits {
  using Point_2 = Position;
  struct Less_x_2 {
    bool operator()(const Position& a, const Position& b) const { return a.u < b.u; }
  };
  struct Less_y_2 {
    bool operator()(const Position& a, const Position& b) const { return a.v < b.v; }
  };
  struct Compute_x_2 {
    double operator()(const Position& at) const { return at.u; }
  };
  struct Compute_y_2 {
    double operator()(const Position& at) const { return at.v; }
  };
  Less_x_2 less_x_2_object() const { return {}; }
  Less_y_2 less_y_2_object() const { return {}; }
  Compute_x_2 compute_x_2_object() const { return {}; }
  Compute_y_2 compute_y_2_object() const { return {}; }
};

std::vector<SeedTriangle> TriangulateSeeds(std::span<const Seed> seeds) {
  return Triangulator().Triangulate(seeds);
}

const std::vector<SeedTriangle>& Triangulator::Triangulate(std::span<const Seed> seeds) {
  triangles_.clear();
  hull_.clear();
  TakePositions(seeds);
  if (positions_.size() < 3) return triangles_;
  // Along a space-filling curve in rounds, with a shuffle from a fixed start: repeatable.
  CGAL::spatial_sort(positions_.begin(), positions_.end(), SortTraits(),
                     CGAL::Hilbert_sort_middle_policy());
  Delaunay delaunay;
  Delaunay::Face_handle near;
  for (const Position& at : positions_) {
    const auto vertex = delaunay.insert(Point(at.u, at.v), near);
    vertex->info() = at.seed;
    near = vertex->face();
  }
  triangles_.reserve(delaunay.number_of_faces());
  for (const auto face : delaunay.finite_face_handles()) {
    const SeedTriangle triangle{face->vertex(0)->info(), face->vertex(1)->info(),
                                face->vertex(2)->info()};
    if (HasArea(seeds, triangle)) triangles_.push_back(triangle);
  }
  if (triangles_.empty()) return triangles_;
  const auto first = delaunay.incident_vertices(delaunay.infinite_vertex());
  auto vertex = first;
  do hull_.push_back(vertex->info());
  while (--vertex != first);
  return triangles_;
}

// The first seed of each position, in an order that does not depend on the seeds' order. Row by
// row, as they often come.
void Triangulator::TakePositions(std::span<const Seed> seeds) {
  positions_.clear();
  positions_.reserve(seeds.size());
  for (const Seed& seed : seeds) {
    positions_.push_back({Steps(seed.u), Steps(seed.v), static_cast<int>(positions_.size())});
  }
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
}

}  // namespace sprout
