#include "services/prior/border.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace sprout {

const BorderExtender::Extended& BorderExtender::Extend(const SeedSurface& surface,
                                                       std::span<const SeedTriangle> triangles,
                                                       std::span<const int> hull, cv::Size size,
                                                       double reach_px) {
  extended_.surface = surface;
  extended_.triangles.assign(triangles.begin(), triangles.end());
  reach_px_ = static_cast<float>(reach_px);
  last_column_ = static_cast<float>(size.width - 1);
  last_row_ = static_cast<float>(size.height - 1);
  for (size_t i = 0; i < hull.size(); ++i) {
    const int before = hull[i];
    const int seed = hull[(i + 1) % hull.size()];
    const int behind = hull[(i + 2) % hull.size()];
    const Side side = Beyond(PlaneOf(before), PlaneOf(seed));
    FillAcross(before, seed, side);
    FillCorners(seed, side, Beyond(PlaneOf(seed), PlaneOf(behind)));
  }
  return extended_;
}

// The side that a hull's edge from a to b faces.
BorderExtender::Side BorderExtender::Beyond(const LocalPlane& a, const LocalPlane& b) {
  const float right = b.v - a.v;  // of the edge's normal, which points outwards
  const float down = a.u - b.u;
  if (std::abs(right) > std::abs(down)) return right > 0 ? kRight : kLeft;
  return down > 0 ? kBottom : kTop;
}

BorderExtender::Direction BorderExtender::DirectionOf(Side side) {
  constexpr Direction kDirections[] = {{0, -1}, {1, 0}, {0, 1}, {-1, 0}};
  return kDirections[side];
}

int BorderExtender::AddPlane(int seed, float u, float v) {
  std::vector<LocalPlane>& planes = extended_.surface.planes;
  LocalPlane plane = PlaneOf(seed);
  // A slant is known to about so many px a pixel; over the distance that makes a disparity.
  constexpr float kSlantSigma = 0.05F;
  plane.sigma_px = std::hypot(plane.sigma_px, kSlantSigma * std::hypot(u - plane.u, v - plane.v));
  plane.disparity = std::clamp(plane.At(u, v), 0.F, last_column_);  // of what two images can show
  plane.u = u;
  plane.v = v;
  planes.push_back(plane);
  return static_cast<int>(planes.size()) - 1;
}

// At a side, or with two directions in a corner; or on the way there. Seeds beyond the border stay
// where they are.
int BorderExtender::AddAtBorder(int seed, Direction towards) {
  const auto border = [&](float at, int direction, float last) {
    if (direction == 0) return at;
    return direction < 0 ? std::min(at, std::max(at - reach_px_, 0.F))
                         : std::max(at, std::min(at + reach_px_, last));
  };
  return AddPlane(seed, border(PlaneOf(seed).u, towards.columns, last_column_),
                  border(PlaneOf(seed).v, towards.rows, last_row_));
}

void BorderExtender::AddTriangle(int a, int b, int c) {
  constexpr float kLeastArea = 1e-3F;  // px²; seeds may lie on the border
  const LocalPlane &at_a = PlaneOf(a), &at_b = PlaneOf(b), &at_c = PlaneOf(c);
  const float area = (at_b.u - at_a.u) * (at_c.v - at_a.v) - (at_c.u - at_a.u) * (at_b.v - at_a.v);
  if (std::abs(area) > kLeastArea) extended_.triangles.push_back({a, b, c});
}

void BorderExtender::FillAcross(int a, int b, Side side) {
  const int at_a = AddAtBorder(a, DirectionOf(side));
  const int at_b = AddAtBorder(b, DirectionOf(side));
  AddTriangle(a, b, at_b);
  AddTriangle(a, at_b, at_a);
}

void BorderExtender::FillCorners(int seed, Side from, Side to) {
  if (from == Next(to)) return;  // a hull turns one way only, but for rounding
  for (Side side = from; side != to; side = Next(side)) {
    const Direction one = DirectionOf(side);
    const Direction other = DirectionOf(Next(side));
    const int corner = AddAtBorder(seed, {one.columns + other.columns, one.rows + other.rows});
    AddTriangle(seed, AddAtBorder(seed, one), corner);
    AddTriangle(seed, corner, AddAtBorder(seed, other));
  }
}

}  // namespace sprout
