#include "services/prior/delaunay.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "common/core/parallel.h"

namespace sprout {
namespace {

constexpr float kStepsPerPixel = 64;
constexpr size_t kFewestOfStrip = 1000;  // positions; fewer are not worth a seam

int Steps(float px) {
  constexpr auto kFarthest = static_cast<float>(DelaunayMesh::kFarthest);
  return static_cast<int>(std::lround(std::clamp(px * kStepsPerPixel, -kFarthest, kFarthest)));
}

// In the order of rows, then of columns, then of ids.
bool IsBefore(const MeshPosition& a, const MeshPosition& b) {
  const auto key = [](const MeshPosition& at) { return (int64_t{at.v} << 32) + at.u; };
  return key(a) != key(b) ? key(a) < key(b) : a.id < b.id;
}

// The circle through three positions that are counter-clockwise with v upwards, seen from the
// first; scaled so that nothing has to be divided.
class Circle {
 public:
  Circle(const MeshPosition& a, const MeshPosition& b, const MeshPosition& c) {
    const int64_t bu = int64_t{b.u} - a.u, bv = int64_t{b.v} - a.v;
    const int64_t cu = int64_t{c.u} - a.u, cv = int64_t{c.v} - a.v;
    const auto bb = static_cast<double>(bu * bu + bv * bv);
    const auto cc = static_cast<double>(cu * cu + cv * cv);
    scale_ = 2 * static_cast<double>(bu * cv - bv * cu);
    u_ = static_cast<double>(cv) * bb - static_cast<double>(bv) * cc;
    v_ = static_cast<double>(bu) * cc - static_cast<double>(cu) * bb;
    const auto length = [](int64_t u, int64_t v) {
      return static_cast<double>(std::abs(u) + std::abs(v));
    };
    doubt_ = 1e-14 * (length(cu, cv) * bb + length(bu, bv) * cc);
  }

  // Whether it stays on the first position's side of a line that is so many steps below that one;
  // above, where they are negative. When in doubt, no.
  bool StaysClearOf(int64_t steps) const {
    const double line = std::abs(static_cast<double>(steps)) * scale_;
    const double centre = steps < 0 ? -v_ : v_;
    const double radius = std::sqrt(u_ * u_ + v_ * v_);
    return centre + radius + doubt_ < line;
  }

 private:
  double scale_;
  double u_;
  double v_;
  double doubt_;  // more than rounding can err
};

// The same triangle, from its smallest id on.
MeshTriangle FromSmallest(const MeshTriangle& triangle) {
  MeshTriangle turned = triangle;
  std::rotate(turned.begin(), std::min_element(turned.begin(), turned.end()), turned.end());
  return turned;
}

// Not so for seeds so nearly on one line that only the rounding of their positions parts them.
bool HasArea(std::span<const Seed> seeds, const SeedTriangle& triangle) {
  const auto seed = [&](size_t i) -> const Seed& {
    return seeds[static_cast<size_t>(triangle[i])];
  };
  const double bu = double{seed(1).u} - seed(0).u, bv = double{seed(1).v} - seed(0).v;
  const double cu = double{seed(2).u} - seed(0).u, cv = double{seed(2).v} - seed(0).v;
  return bu * cv > bv * cu;
}

}  // namespace

std::vector<SeedTriangle> TriangulateSeeds(std::span<const Seed> seeds) {
  return Triangulator().Triangulate(seeds);
}

const std::vector<SeedTriangle>& Triangulator::Triangulate(std::span<const Seed> seeds) {
  TakePositions(seeds);
  CutIntoStrips();
  ForEachParallel(strips_.size(), [&](size_t i) { Settle(seeds, strips_[i]); });
  triangles_.clear();
  triangles_.reserve(2 * positions_.size());
  for (const Strip& strip : strips_) {
    triangles_.insert(triangles_.end(), strip.settled.begin(), strip.settled.end());
  }
  Sew(seeds);
  hull_.clear();
  if (triangles_.empty()) return triangles_;
  for (int place : seam_.hull()) hull_.push_back(seeds_[static_cast<size_t>(place)]);
  return triangles_;
}

// The first seed of each position, in an order that does not depend on the seeds' order.
void Triangulator::TakePositions(std::span<const Seed> seeds) {
  positions_.clear();
  positions_.reserve(seeds.size());
  for (const Seed& seed : seeds) {
    positions_.push_back({Steps(seed.u), Steps(seed.v), static_cast<int>(positions_.size())});
  }
  SortPositions();
  const auto same = [](const MeshPosition& a, const MeshPosition& b) {
    return a.u == b.u && a.v == b.v;
  };
  positions_.erase(std::unique(positions_.begin(), positions_.end(), same), positions_.end());
  seeds_.clear();
  seeds_.reserve(positions_.size());
  for (MeshPosition& position : positions_) {
    const auto place = static_cast<int>(seeds_.size());
    seeds_.push_back(std::exchange(position.id, place));
  }
}

// In two halves at the same time. Often they come row by row.
void Triangulator::SortPositions() {
  if (std::is_sorted(positions_.begin(), positions_.end(), IsBefore)) return;
  const auto middle = positions_.begin() + std::ssize(positions_) / 2;
  RunBoth([&] { std::sort(positions_.begin(), middle, IsBefore); },
          [&] { std::sort(middle, positions_.end(), IsBefore); });
  std::swap(positions_, unsorted_);
  positions_.resize(unsorted_.size());
  std::merge(unsorted_.begin(), middle, middle, unsorted_.end(), positions_.begin(), IsBefore);
}

void Triangulator::CutIntoStrips() {
  const size_t count = positions_.size();
  const size_t parts = std::clamp(count / kFewestOfStrip, size_t{1}, strips_.size());
  for (size_t i = 0; i < strips_.size(); ++i) {
    strips_[i].begin = count * std::min(i, parts) / parts;
    strips_[i].end = count * std::min(i + 1, parts) / parts;
  }
  is_at_seam_.assign(count, 0);
}

// Touches nothing but the strip and what belongs to its positions.
void Triangulator::Settle(std::span<const Seed> seeds, Strip& strip) {
  strip.mesh.Triangulate(std::span(positions_).subspan(strip.begin, strip.end - strip.begin));
  strip.settled.clear();
  strip.doubtful.clear();
  const auto add_to_seam = [&](int place) { is_at_seam_[static_cast<size_t>(place)] = 1; };
  for (const MeshTriangle& triangle : strip.mesh.triangles()) {
    if (StaysClear(triangle, strip)) {
      Add(seeds, triangle, strip.settled);
    } else {
      strip.doubtful.push_back(FromSmallest(triangle));
      std::for_each(triangle.begin(), triangle.end(), add_to_seam);
    }
  }
  std::sort(strip.doubtful.begin(), strip.doubtful.end());
  std::for_each(strip.mesh.hull().begin(), strip.mesh.hull().end(), add_to_seam);
}

// Whether no position of another strip can lie in a triangle's circle or on it.
bool Triangulator::StaysClear(const MeshTriangle& triangle, const Strip& strip) const {
  const auto at = [&](size_t corner) -> const MeshPosition& {
    return positions_[static_cast<size_t>(triangle[corner])];
  };
  const Circle circle(at(0), at(1), at(2));
  const auto stays_clear_of = [&](size_t place) {
    return circle.StaysClearOf(int64_t{positions_[place].v} - at(0).v);
  };
  return (strip.begin == 0 || stays_clear_of(strip.begin - 1)) &&
         (strip.end == positions_.size() || stays_clear_of(strip.end));
}

// Adds the triangles that no strip could settle.
void Triangulator::Sew(std::span<const Seed> seeds) {
  seam_positions_.clear();
  for (const MeshPosition& position : positions_) {
    if (is_at_seam_[static_cast<size_t>(position.id)] != 0) seam_positions_.push_back(position);
  }
  seam_.Triangulate(seam_positions_);
  for (const MeshTriangle& triangle : seam_.triangles()) {
    if (IsOfTheWhole(triangle)) Add(seeds, triangle, triangles_);
  }
}

// Of a triangle of the seam.
bool Triangulator::IsOfTheWhole(const MeshTriangle& triangle) const {
  const auto [least, most] = std::minmax({triangle[0], triangle[1], triangle[2]});
  const auto strip = std::find_if(strips_.begin(), strips_.end(), [least = least](const Strip& s) {
    return static_cast<size_t>(least) < s.end;
  });
  return static_cast<size_t>(most) >= strip->end ||
         std::binary_search(strip->doubtful.begin(), strip->doubtful.end(), FromSmallest(triangle));
}

// A triangle of places.
void Triangulator::Add(std::span<const Seed> seeds, const MeshTriangle& triangle,
                       std::vector<SeedTriangle>& triangles) const {
  const auto seed = [&](size_t corner) { return seeds_[static_cast<size_t>(triangle[corner])]; };
  const SeedTriangle of_seeds{seed(0), seed(1), seed(2)};
  if (HasArea(seeds, of_seeds)) triangles.push_back(of_seeds);
}

}  // namespace sprout
