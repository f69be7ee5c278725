#include "services/prior/triangulation/grid_cells.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <tuple>

#include "common/core/parallel.h"

namespace sprout::prior {
namespace {

constexpr int kNone = -1;

using Corners = std::array<int, 4>;  // of a cell: its points

// The circle through three points that run counter-clockwise.
struct Circle {
  double u, v, squared_radius;
};

// @returns nothing for triangles that run the other way round, or are so flat that rounding shows.
std::optional<Circle> CircleThrough(const GridPoint& a, const GridPoint& b, const GridPoint& c) {
  constexpr double kMinArea = 1e-2;     // twice the area, over the squares of two sides
  constexpr double kMinRadius = 1e-12;  // over the distance from (0, 0); both squared
  const double bu = double{b.u} - a.u, bv = double{b.v} - a.v;
  const double cu = double{c.u} - a.u, cv = double{c.v} - a.v;
  const double bb = bu * bu + bv * bv;
  const double cc = cu * cu + cv * cv;
  const double twice_area = bu * cv - bv * cu;
  if (!(twice_area > kMinArea * (bb + cc))) return std::nullopt;
  const double du = (cv * bb - bv * cc) / (2 * twice_area);
  const double dv = (bu * cc - cu * bb) / (2 * twice_area);
  const Circle circle{a.u + du, a.v + dv, du * du + dv * dv};
  const double squared_distance = circle.u * circle.u + circle.v * circle.v;
  if (!(circle.squared_radius > kMinRadius * squared_distance)) return std::nullopt;
  return circle;
}

enum class Side { kInside, kNear, kOutside };

// Near is where rounding might hide on which side a point lies: circles through triangles that are
// not flat are right to 10⁻¹⁰ of their size.
Side SideOf(const Circle& circle, const GridPoint& point) {
  constexpr double kNear = 1e-9;
  const double du = point.u - circle.u;
  const double dv = point.v - circle.v;
  const double off = du * du + dv * dv - circle.squared_radius;
  if (std::abs(off) <= kNear * circle.squared_radius) return Side::kNear;
  return off < 0 ? Side::kInside : Side::kOutside;
}

// Whether four points lie on one circle to the last bit. False where whole numbers do not tell.
bool AreOnOneCircle(const GridPoint& a, const GridPoint& b, const GridPoint& c,
                    const GridPoint& d) {
  constexpr double kUnits = 1 << 16;     // a px: what a float has in an image of 128 px and more
  constexpr double kMaxUnits = 1 << 28;  // the product of four fits into 128 bits
  bool is_whole = true;
  const auto whole = [&](double px) {
    const double units = px * kUnits;
    is_whole = is_whole && std::abs(units) < kMaxUnits && units == std::floor(units);
    return is_whole ? static_cast<int64_t>(units) : 0;
  };
  struct Vector {
    int64_t u, v;
    int64_t Square() const { return u * u + v * v; }
  };
  const auto from_d = [&](const GridPoint& point) {
    return Vector{whole(double{point.u} - d.u), whole(double{point.v} - d.v)};
  };
  const Vector one = from_d(a), two = from_d(b), three = from_d(c);
  if (!is_whole) return false;
  __extension__ using Wide = __int128;
  const auto product = [](const Vector& square, const Vector& x, const Vector& y) {
    return Wide{square.Square()} * (x.u * y.v - x.v * y.u);
  };
  return product(one, two, three) + product(two, three, one) + product(three, one, two) == 0;
}

bool IsBefore(const GridPoint& one, const GridPoint& other) {
  return std::tie(one.u, one.v) < std::tie(other.u, other.v);
}

}  // namespace

// Points sorted into square cells of the left image, about one a cell.
class PointsByCell {
 public:
  explicit PointsByCell(std::span<const GridPoint> points);

  // Whether there is no point in or near the circle but these.
  bool IsEmpty(const Circle& circle, const Corners& corners) const;

 private:
  int Column(double u) const { return Cell((u - least_u_) * per_px_, columns_); }
  int Row(double v) const { return Cell((v - least_v_) * per_px_, rows_); }
  static int Cell(double at, int count) {
    return static_cast<int>(std::clamp(at, 0.0, static_cast<double>(count - 1)));
  }

  struct Sorted {
    GridPoint point;
    int number;
  };

  double least_u_ = 0, least_v_ = 0, per_px_ = 1;
  int columns_ = 1, rows_ = 1;
  std::vector<Sorted> sorted_;
  std::vector<int> first_;  // of each cell, one more than cells
};

PointsByCell::PointsByCell(std::span<const GridPoint> points) {
  constexpr double kMaxAcross = 1024;  // cells; points may lie anywhere
  double most_u = 0, most_v = 0;
  for (size_t i = 0; i < points.size(); ++i) {
    const double u = points[i].u, v = points[i].v;
    least_u_ = i == 0 ? u : std::min(least_u_, u);
    least_v_ = i == 0 ? v : std::min(least_v_, v);
    most_u = i == 0 ? u : std::max(most_u, u);
    most_v = i == 0 ? v : std::max(most_v, v);
  }
  const double width = most_u - least_u_, height = most_v - least_v_;
  const double cell_px = std::max({std::sqrt(width * height / static_cast<double>(points.size())),
                                   std::max(width, height) / kMaxAcross, 1e-3});
  per_px_ = 1 / cell_px;
  columns_ = static_cast<int>(width * per_px_) + 1;
  rows_ = static_cast<int>(height * per_px_) + 1;
  const auto cell_of = [&](const GridPoint& point) {
    return static_cast<size_t>(Row(point.v) * columns_ + Column(point.u));
  };
  first_.assign(static_cast<size_t>(columns_) * static_cast<size_t>(rows_) + 2, 0);
  for (const GridPoint& point : points) ++first_[cell_of(point) + 2];
  for (size_t i = 2; i < first_.size(); ++i) first_[i] += first_[i - 1];
  sorted_.resize(points.size());
  for (size_t i = 0; i < points.size(); ++i) {  // moves first_[cell + 1] to the cell's end
    sorted_[static_cast<size_t>(first_[cell_of(points[i]) + 1]++)] = {points[i],
                                                                      static_cast<int>(i)};
  }
  first_.pop_back();
}

bool PointsByCell::IsEmpty(const Circle& circle, const Corners& corners) const {
  constexpr int kMaxPoints = 100;  // that are looked at; a usual circle needs about ten
  const double radius = std::sqrt(circle.squared_radius) * (1 + 1e-6);
  const int left = Column(circle.u - radius);
  const int right = Column(circle.u + radius);
  const int bottom = Row(circle.v + radius);
  int looked_at = 0;
  for (int row = Row(circle.v - radius); row <= bottom; ++row) {
    const int* const firsts = first_.data() + row * columns_;
    const int end = firsts[right + 1];
    looked_at += end - firsts[left] + 1;
    if (looked_at > kMaxPoints) return false;
    for (int i = firsts[left]; i < end; ++i) {
      const Sorted& at = sorted_[static_cast<size_t>(i)];
      if (SideOf(circle, at.point) != Side::kOutside &&
          std::find(corners.begin(), corners.end(), at.number) == corners.end()) {
        return false;
      }
    }
  }
  return true;
}

GridCells::GridCells(std::span<const GridPoint> points) : points_(points) {
  FindColumnsAndRows();
  if (columns_ == 0) return;
  point_at_.assign(static_cast<size_t>(columns_) * static_cast<size_t>(rows_), kNone);
  for (size_t i = 0; i < points.size(); ++i) {
    if (points[i].tof_u < 0 || points[i].tof_v < 0) continue;
    int& at = point_at_[static_cast<size_t>(points[i].tof_v * columns_ + points[i].tof_u)];
    if (at == kNone) at = static_cast<int>(i);
  }
  const PointsByCell near(points);
  diagonals_.assign(point_at_.size(), kNotIntact);
  ForRangesParallel(rows_ - 1, 4 * cv::getNumThreads(), [&](const cv::Range& part) {
    for (int y = part.start; y < part.end; ++y) {
      for (int x = 0; x + 1 < columns_; ++x) {
        diagonals_[static_cast<size_t>(y * columns_ + x)] = DiagonalOf(x, y, near);
      }
    }
  });
  any_intact_ = std::any_of(diagonals_.begin(), diagonals_.end(),
                            [](Diagonal diagonal) { return diagonal != kNotIntact; });
}

void GridCells::FindColumnsAndRows() {
  size_t known = 0;
  for (const GridPoint& point : points_) {
    if (point.tof_u < 0 || point.tof_v < 0) continue;
    ++known;
    columns_ = std::max(columns_, point.tof_u + 1);
    rows_ = std::max(rows_, point.tof_v + 1);
  }
  // A ToF image of which so little is left has no intact cells, and its size may be made up. One
  // row or column has no cells at all.
  constexpr size_t kMinShare = 8;
  if (columns_ < 2 || rows_ < 2 ||
      kMinShare * known < static_cast<size_t>(columns_) * static_cast<size_t>(rows_)) {
    columns_ = rows_ = 0;
  }
}

int GridCells::PointAt(int x, int y) const {
  return point_at_[static_cast<size_t>(y * columns_ + x)];
}

GridCells::Diagonal GridCells::DiagonalOf(int x, int y, const PointsByCell& near) const {
  const Corners corners{PointAt(x, y), PointAt(x + 1, y), PointAt(x, y + 1), PointAt(x + 1, y + 1)};
  if (*std::min_element(corners.begin(), corners.end()) == kNone) return kNotIntact;
  const auto at = [&](size_t i) -> const GridPoint& {
    return points_[static_cast<size_t>(corners[i])];
  };
  const GridPoint &a = at(0), &b = at(1), &c = at(2), &d = at(3);
  const std::optional<Circle> abd = CircleThrough(a, b, d);
  const Side side_of_c = abd ? SideOf(*abd, c) : Side::kInside;
  if (side_of_c == Side::kNear && !AreOnOneCircle(a, b, d, c)) return kNotIntact;
  const bool cuts_c_off = side_of_c == Side::kNear
                              ? IsBefore(std::max(a, d, IsBefore), std::max(b, c, IsBefore))
                              : side_of_c == Side::kOutside;
  const auto both_empty = [&](const std::optional<Circle>& one,
                              const std::optional<Circle>& other) {
    return one && other && near.IsEmpty(*one, corners) && near.IsEmpty(*other, corners);
  };
  if (cuts_c_off) return both_empty(abd, CircleThrough(a, d, c)) ? kFromAToD : kNotIntact;
  const std::optional<Circle> abc = CircleThrough(a, b, c);
  // If a, b, d are too flat to tell, c may lie outside their circle; then d lies inside this one.
  if (!abd && abc && SideOf(*abc, d) != Side::kOutside) return kNotIntact;
  return both_empty(abc, CircleThrough(b, d, c)) ? kFromBToC : kNotIntact;
}

GridCells::Diagonal GridCells::At(int x, int y) const {
  if (x < 0 || y < 0 || x + 1 >= columns_ || y + 1 >= rows_) return kNotIntact;
  return diagonals_[static_cast<size_t>(y * columns_ + x)];
}

bool GridCells::IsInside(int point) const {
  const int x = points_[static_cast<size_t>(point)].tof_u;
  const int y = points_[static_cast<size_t>(point)].tof_v;
  return At(x, y) != kNotIntact && At(x - 1, y) != kNotIntact && At(x - 1, y - 1) != kNotIntact &&
         At(x, y - 1) != kNotIntact && PointAt(x, y) == point;
}

void GridCells::AddFan(int point, std::vector<FanTriangle>& fan) const {
  const int x = points_[static_cast<size_t>(point)].tof_u;
  const int y = points_[static_cast<size_t>(point)].tof_v;
  if (x < 0 || y < 0 || x >= columns_ || y >= rows_ || PointAt(x, y) != point) return;
  // The cells below right, below left, above left and above right.
  for (const auto& [step_u, step_v] : {std::pair(1, 1), {-1, 1}, {-1, -1}, {1, -1}}) {
    const Diagonal diagonal = At(std::min(x, x + step_u), std::min(y, y + step_v));
    if (diagonal == kNotIntact) continue;
    int from = PointAt(x + step_u, y), to = PointAt(x, y + step_v);
    if (step_u != step_v) std::swap(from, to);
    if (diagonal == (step_u == step_v ? kFromAToD : kFromBToC)) {  // it starts at the point
      const int opposite = PointAt(x + step_u, y + step_v);
      fan.push_back({from, opposite});
      fan.push_back({opposite, to});
    } else {
      fan.push_back({from, to});
    }
  }
}

bool GridCells::HasTriangle(int from, int to) const {
  const GridPoint& one = points_[static_cast<size_t>(from)];
  const GridPoint& other = points_[static_cast<size_t>(to)];
  const int x = one.tof_u, y = one.tof_v;
  const int step_u = other.tof_u - x, step_v = other.tof_v - y;
  if (x < 0 || y < 0 || other.tof_u < 0 || other.tof_v < 0 || x >= columns_ || y >= rows_ ||
      std::abs(step_u) > 1 || std::abs(step_v) > 1 || PointAt(x, y) != from ||
      PointAt(other.tof_u, other.tof_v) != to) {
    return false;
  }
  if (step_u != 0 && step_v != 0) {  // a diagonal has a triangle on either side
    const Diagonal diagonal = step_u == step_v ? kFromAToD : kFromBToC;
    return At(std::min(x, x + step_u), std::min(y, y + step_v)) == diagonal;
  }
  if (step_v == 0) return At(step_u > 0 ? x : x - 1, step_u > 0 ? y : y - 1) != kNotIntact;
  return At(step_v > 0 ? x - 1 : x, step_v > 0 ? y : y - 1) != kNotIntact;
}

}  // namespace sprout::prior
