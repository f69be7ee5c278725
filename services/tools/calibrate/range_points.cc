#include "services/tools/calibrate/range_points.h"

#include <cmath>

#include "common/geometry/lens.h"

namespace sprout::calibrate {
namespace {

// At the rim of a square a pixel sees two colours, and at that of the board what is behind it.
constexpr double kRimPerSquare = 0.1;

// The mean of fewer pixels is noisy, and on a slant not at the middle of the square.
constexpr int kMinPixels = 6;

struct SquareSum {
  int pixels = 0;
  cv::Point2d pixel;
  double inverse_depth = 0;
};

// (x, y, 1) of each pixel.
cv::Mat2d Directions(const Lens& lens) {
  cv::Mat2d directions(lens.size());
  for (int v = 0; v < lens.height; ++v) {
    for (int u = 0; u < lens.width; ++u) {
      const Eigen::Vector2d d = DirectionOfPixel(lens, {double(u), double(v)});
      directions(v, u) = {d.x(), d.y()};
    }
  }
  return directions;
}

// Column or row of the square that a coordinate on the board lies in; −1: in none, or at its rim.
int SquareAt(double position_m, double square_m, int squares) {
  const double position = position_m / square_m;
  const double whole = std::floor(position);
  if (!(whole >= 0 && whole < squares)) return -1;
  const double part = position - whole;
  return part < kRimPerSquare || part > 1 - kRimPerSquare ? -1 : static_cast<int>(whole);
}

}  // namespace

std::vector<RangePoint> CollectRangePoints(const Board& board, const std::vector<BoardView>& views,
                                           const RigModel& model) {
  const BoardSize& size = board.size();
  const double pitch_m = board.extent_m().x() / size.columns;
  const cv::Mat2d directions = Directions(model.lenses[kTof]);
  std::vector<RangePoint> points;
  for (size_t view = 0; view < views.size(); ++view) {
    const cv::Mat1f& depth_m = views[view].tof.depth_m;
    if (depth_m.empty()) continue;
    const Eigen::Isometry3d board_from_tof = ToTransform(model.left_from_board[view]).inverse() *
                                             ToTransform(model.left_from_camera[kTof]);
    const Eigen::Vector3d from = board_from_tof.translation();
    std::vector<SquareSum> sums(static_cast<size_t>(size.columns * size.rows));
    for (int v = 0; v < depth_m.rows; ++v) {
      for (int u = 0; u < depth_m.cols; ++u) {
        if (!IsReturn(depth_m(v, u))) continue;
        const Eigen::Vector3d ray =
            board_from_tof.linear() * Eigen::Vector3d(directions(v, u)[0], directions(v, u)[1], 1);
        const double to_plane = -from.z() / ray.z();
        if (!(to_plane > 0)) continue;
        const Eigen::Vector3d hit = from + to_plane * ray;
        const int column = SquareAt(hit.x(), pitch_m, size.columns);
        const int row = SquareAt(hit.y(), pitch_m, size.rows);
        if (column < 0 || row < 0) continue;
        SquareSum& sum = sums[static_cast<size_t>(row * size.columns + column)];
        ++sum.pixels;
        sum.pixel += cv::Point2d(u, v);
        sum.inverse_depth += 1 / double{depth_m(v, u)};
      }
    }
    for (const SquareSum& sum : sums) {
      if (sum.pixels < kMinPixels) continue;
      points.push_back({.view = view,
                        .pixel = sum.pixel / sum.pixels,
                        .depth_m = sum.pixels / sum.inverse_depth});
    }
  }
  return points;
}

}  // namespace sprout::calibrate
