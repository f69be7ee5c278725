#include <algorithm>
#include <cmath>
#include <tuple>

#include "common/core/parallel.h"
#include "services/refine/surface/surface_rules.h"
#include "services/refine/surface/tof_surface.h"

// Those parts of TofSurface that find hidden points, eq. (R1) of the README.
namespace sprout::refine {
namespace {

constexpr size_t kMaxPieces = SurfaceRules::kMaxPieces;

// An order of all points of a ToF image.
bool IsNearer(const ProjectedPoint& a, const ProjectedPoint& b) {
  const auto key = [](const ProjectedPoint& point) {
    return std::tuple(-point.seed.disparity(), point.tof_v, point.tof_u);
  };
  return key(a) < key(b);
}

}  // namespace

// The nearest point of each cell between beams.
void TofSurface::SortForPieces(std::span<const ProjectedPoint> points) {
  const int rows = tof_rows_ / next_row_ + 3;
  nearest_of_cell_.assign(static_cast<size_t>(stride_) * static_cast<size_t>(rows), -1);
  for (size_t i = 0; i < points.size(); ++i) {
    int32_t& nearest = nearest_of_cell_[PieceCell(points[i])];
    if (nearest < 0 || IsNearer(points[i], points[static_cast<size_t>(nearest)])) {
      nearest = static_cast<int32_t>(i);
    }
  }
}

// Slopes to the points of the cells around, at the places where these really are.
TofSurface::Piece TofSurface::PieceOf(std::span<const ProjectedPoint> points,
                                      const ProjectedPoint& point) const {
  using Rules = SurfaceRules;
  const size_t cell = PieceCell(point);
  const auto at = [&](std::ptrdiff_t step) {
    const int32_t index =
        nearest_of_cell_[static_cast<size_t>(static_cast<std::ptrdiff_t>(cell) + step)];
    return index < 0 ? nullptr : &points[static_cast<size_t>(index)].seed;
  };
  const auto rise = [&](const Seed& seed) { return seed.disparity() - point.seed.disparity(); };
  // The distance is at least half a cell: a point nearer than that would make a steep slope of any
  // step.
  const auto across = [&](int side) {
    const Seed* const seed = at(side);
    if (seed == nullptr) return kNone;
    const auto way = static_cast<float>(side);
    return way * rise(*seed) /
           std::max(way * (seed->u - point.seed.u), static_cast<float>(column_px_ / 2));
  };
  Piece piece{.disparity = point.seed.disparity(),
              .slope = {Gentler(across(1), across(-1)), 0},
              .unseen = {0, 0}};
  if (std::isnan(piece.slope.x)) {
    piece.slope.x = 0;
    piece.unseen.x = Rules::kUnseenSlope;
  }
  const auto down = [&](int side) {
    const auto way = static_cast<float>(side);
    for (const int beside : {0, -1, 1}) {  // of the next beam
      const Seed* const seed = at(side * stride_ + beside);
      if (seed == nullptr) continue;
      return way * (rise(*seed) - piece.slope.x * (seed->u - point.seed.u)) /
             std::max(way * (seed->v - point.seed.v), static_cast<float>(next_row_px_ / 2));
    }
    return kNone;
  };
  piece.slope.y = Gentler(down(1), down(-1));
  if (std::isnan(piece.slope.y)) {
    piece.slope.y = 0;
    piece.unseen.y = Rules::kUnseenSlope;
  }
  return piece;
}

// One point against the pieces around it.
class TofSurface::HiddenTest {
 public:
  HiddenTest(const TofSurface& surface, std::span<const ProjectedPoint> points,
             const cv::Mat1b& left, const cv::Mat1b& right, const HiddenRule& rule)
      : surface_(surface), points_(points), left_(left), right_(right), rule_(rule) {}

  bool IsHiddenIn(const View& view, size_t i) const {
    Point point{.index = i, .difference = {}};
    return view.cells.AnyNeighbour(view.positions[i],
                                   [&](size_t other) { return Hides(view, other, point); });
  }

 private:
  struct Point {
    size_t index;
    std::optional<double> difference;  // of the images there, once it was asked for
  };

  // Whether the piece of a point hides another one, by eq. (R1).
  bool Hides(const View& view, size_t by, Point& point) const {
    using Rules = SurfaceRules;
    const cv::Point2f off = view.positions[point.index] - view.positions[by];
    const double across = off.x / surface_.piece_px_.x;
    const double down = off.y / surface_.piece_px_.y;
    if (across * across + down * down > rule_.reach * rule_.reach) return false;
    const Piece& piece = surface_.pieces_[by];
    const Seed& seed = points_[point.index].seed;
    const bool is_left = &view == &surface_.left_;
    // A px of the right image is 1 − slope px of the left one.
    const double steps = is_left ? 1 : std::max(1 - double{piece.slope.x}, Rules::kMinSeen);
    const double piece_px = piece.disparity + double{off.dot(piece.slope)} / steps;
    const double behind_px = piece_px - seed.disparity();
    if (behind_px <= rule_.tolerance_px) return false;  // the least of the tolerance
    const double distance_px = std::sqrt(double{off.x} * off.x + double{off.y} * off.y);
    const double tolerance_px = rule_.tolerance_px + Rules::kPiecePerPx * distance_px +
                                std::abs(off.x) * piece.unseen.x + std::abs(off.y) * piece.unseen.y;
    if (behind_px <= tolerance_px) return false;
    const double distance = std::sqrt(across * across + down * down);
    const double beside = 1 + Rules::kHalfAtCore * distance / std::max(rule_.core, Rules::kMinCore);
    const double odds = std::sqrt(behind_px / tolerance_px) / (beside * beside);
    // The piece at this pixel: what it would be in the other image.
    const double u = is_left ? seed.u : seed.u_right + piece_px;
    const double u_right = is_left ? seed.u - piece_px : seed.u_right;
    if (!point.difference) point.difference = Difference(seed.u, seed.v, seed.u_right);
    const double of_point = odds * (*point.difference + Rules::kNoise);
    if (of_point <= Rules::kNoise) return false;  // whatever the other is
    const double of_piece = Difference(u, seed.v, u_right);
    // Outside an image there is nothing to compare.
    if (std::isinf(of_piece) || std::isinf(*point.difference)) return odds > 1;
    return of_point > of_piece + Rules::kNoise;
  }

  double Difference(double u, double v, double u_right) const {
    return WindowDifference(left_, right_, u, v, u_right);
  }

  const TofSurface& surface_;
  std::span<const ProjectedPoint> points_;
  const cv::Mat1b& left_;
  const cv::Mat1b& right_;
  const HiddenRule& rule_;
};

const std::vector<Hidden>& TofSurface::FindHidden(std::span<const ProjectedPoint> points,
                                                  size_t in_both, const cv::Mat1b& left,
                                                  const cv::Mat1b& right, const HiddenRule& rule) {
  hidden_.assign(points.size(), {});
  if (rule.reach <= 0) return hidden_;
  const double cell_px =
      std::max(SurfaceRules::kMinCellPx, rule.reach * std::max(piece_px_.x, piece_px_.y));
  const auto look = [&](size_t count, float Seed::*column, View& view) {
    view.positions.clear();
    for (const auto& [u, v, seed] : points.first(count)) {
      view.positions.emplace_back(seed.*column, seed.v);
    }
    view.cells.Fill(view.positions, size_, cell_px, kMaxPieces, [&](std::span<uint32_t> cell) {
      std::nth_element(cell.begin(), cell.begin() + kMaxPieces, cell.end(),
                       [&](uint32_t a, uint32_t b) { return IsNearer(points[a], points[b]); });
      return kMaxPieces;
    });
  };
  RunBoth(
      [&] {
        look(points.size(), &Seed::u, left_);
        SortForPieces(points);
        pieces_.clear();
        for (const ProjectedPoint& point : points) pieces_.push_back(PieceOf(points, point));
      },
      [&] { look(in_both, &Seed::u_right, right_); });

  const HiddenTest test(*this, points, left, right, rule);
  ForEachParallel(points.size(), [&](size_t i) {
    hidden_[i] = {.from_left = test.IsHiddenIn(left_, i),
                  .from_right = i < in_both && test.IsHiddenIn(right_, i)};
  });
  return hidden_;
}

}  // namespace sprout::refine
