#include "services/tools/calibrate/board_finder.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "common/core/quantile.h"

namespace sprout::calibrate {
namespace {

// OpenCV's detector needs markers of some 20 px and edges of several px.
constexpr int kUpscale = 4;

// Half a corner's window, in sides of a square: it ends where the marker begins. In an image of few
// pixels it reaches a little further, on an upscaled and smoothed image: the stairs of its pixels
// would move the corner (NOTES.md).
constexpr double kWindowPerSquare = 0.12;
constexpr double kSmallWindowPerSquare = 0.16;
constexpr double kSmoothing = 2.5;
constexpr int kMinHalfWindow = 2;
constexpr int kMaxHalfWindow = 11;
const cv::TermCriteria kSubpixelSteps(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 50, 1e-4);

// A corner that moves further than this share of a square is not the one that was found.
constexpr double kMaxMovePerSquare = 0.25;

// Where two black and two white squares meet, grey levels curve up one way and down the other; at
// least by this share of the image's contrast, both together, over a quarter of a square.
constexpr double kMinSaddle = 0.1;

// Side of a square at each corner: the distance to the nearest neighbour in the grid, px; nothing
// where there is none.
std::vector<std::optional<double>> SquareSides(const BoardCorners& corners, int columns) {
  std::map<int, cv::Point2d> pixel_of;
  for (size_t i = 0; i < corners.ids.size(); ++i) pixel_of[corners.ids[i]] = corners.pixels[i];
  std::vector<std::optional<double>> sides;
  for (size_t i = 0; i < corners.ids.size(); ++i) {
    const int id = corners.ids[i];
    std::optional<double> side;
    const auto look = [&](int neighbour, bool is_in_grid) {
      const auto found = pixel_of.find(neighbour);
      if (!is_in_grid || found == pixel_of.end()) return;
      const double distance = cv::norm(found->second - corners.pixels[i]);
      side = std::min(side.value_or(distance), distance);
    };
    look(id - 1, id % columns != 0);
    look(id + 1, (id + 1) % columns != 0);
    look(id - columns, true);
    look(id + columns, true);
    sides.push_back(side);
  }
  return sides;
}

double Level(const cv::Mat1f& image, const cv::Point2d& p) {
  const int x = std::clamp(static_cast<int>(std::lround(p.x)), 0, image.cols - 1);
  const int y = std::clamp(static_cast<int>(std::lround(p.y)), 0, image.rows - 1);
  return image(y, x);
}

// √−det of the second differences, 0 where that is no saddle.
double SaddleStrength(const cv::Mat1f& image, const cv::Point2d& p, double step) {
  const auto at = [&](double x, double y) { return Level(image, p + step * cv::Point2d(x, y)); };
  const double xx = at(1, 0) + at(-1, 0) - 2 * at(0, 0);
  const double yy = at(0, 1) + at(0, -1) - 2 * at(0, 0);
  const double xy = (at(1, 1) + at(-1, -1) - at(1, -1) - at(-1, 1)) / 2;
  return std::sqrt(std::max(0.0, xy * xy / 4 - xx * yy / 4));
}

// Moves each corner to its sub-pixel position; leaves out places that do not look like a corner.
BoardCorners Refined(const BoardCorners& corners, int columns, const cv::Mat1f& image,
                     double window_per_square) {
  double darkest = 0;
  double brightest = 0;
  cv::minMaxLoc(image, &darkest, &brightest);
  const auto sides = SquareSides(corners, columns);
  BoardCorners refined{.markers = corners.markers};
  for (size_t i = 0; i < corners.ids.size(); ++i) {
    if (!sides[i]) continue;
    const double side = *sides[i];
    const int half = std::clamp(static_cast<int>(std::lround(window_per_square * side)),
                                kMinHalfWindow, kMaxHalfWindow);
    const cv::Rect2d inner(half + 1, half + 1, image.cols - 2 * half - 3,
                           image.rows - 2 * half - 3);
    if (!inner.contains(corners.pixels[i])) continue;
    std::vector<cv::Point2f> point{cv::Point2f(corners.pixels[i])};
    cv::cornerSubPix(image, point, {half, half}, {-1, -1}, kSubpixelSteps);
    const cv::Point2d pixel(point[0]);
    if (cv::norm(pixel - corners.pixels[i]) > kMaxMovePerSquare * side) continue;
    if (SaddleStrength(image, pixel, side / 8) < kMinSaddle * (brightest - darkest)) continue;
    refined.ids.push_back(corners.ids[i]);
    refined.pixels.push_back(pixel);
  }
  return refined;
}

// Coordinates of the upscaled image to those of the image, and back.
cv::Point2d Down(const cv::Point2d& p) {
  return {(p.x + 0.5) / kUpscale - 0.5, (p.y + 0.5) / kUpscale - 0.5};
}
cv::Point2d Up(const cv::Point2d& p) {
  return {(p.x + 0.5) * kUpscale - 0.5, (p.y + 0.5) * kUpscale - 0.5};
}

cv::Mat1f Upscaled(const cv::Mat1f& image) {
  cv::Mat1f large;
  cv::resize(image, large, {}, kUpscale, kUpscale, cv::INTER_CUBIC);
  return large;
}

cv::Mat1f Smoothed(const cv::Mat1f& large) {
  cv::Mat1f smooth;
  cv::GaussianBlur(large, smooth, {}, kSmoothing);
  return smooth;
}

// Grey levels from 0 to 255, not rounded.
cv::Mat1f Levels(const cv::Mat1f& amplitude) {
  std::vector<float> values(amplitude.begin(), amplitude.end());
  std::erase_if(values, [](float value) { return !std::isfinite(value); });
  if (values.empty()) return cv::Mat1f(amplitude.size(), 0.f);
  const auto percentile = [&](size_t percent) {
    return OrderStatistic(values, values.size() * percent / 100);
  };
  const float low = percentile(1);
  const float high = percentile(99);
  cv::Mat1f levels(amplitude.size(), 0.f);
  if (high <= low) return levels;
  std::transform(amplitude.begin(), amplitude.end(), levels.begin(), [&](float value) {
    return std::isfinite(value) ? std::clamp((value - low) / (high - low), 0.f, 1.f) * 255 : 0;
  });
  return levels;
}

cv::Mat1b Rounded(const cv::Mat1f& levels) {
  cv::Mat1b rounded;
  levels.convertTo(rounded, CV_8U);
  return rounded;
}

}  // namespace

BoardCorners FindBoard(const Board& board, const cv::Mat1b& image) {
  cv::Mat1f levels;
  image.convertTo(levels, CV_32F);
  return Refined(ReadBoard(board, image), board.corner_columns(), levels, kWindowPerSquare);
}

BoardCorners FindBoardInAmplitude(const Board& board, const cv::Mat1f& amplitude) {
  if (amplitude.empty()) return {};
  const cv::Mat1f large = Upscaled(Levels(amplitude));
  BoardCorners corners = Refined(ReadBoard(board, Rounded(large)), board.corner_columns(),
                                 Smoothed(large), kSmallWindowPerSquare);
  for (cv::Point2d& pixel : corners.pixels) pixel = Down(pixel);
  return corners;
}

BoardCorners FindCornersNear(const Board& board, const BoardCorners& expected,
                             const cv::Mat1f& amplitude) {
  if (amplitude.empty()) return {};
  BoardCorners corners = expected;
  for (cv::Point2d& pixel : corners.pixels) pixel = Up(pixel);
  corners = Refined(corners, board.corner_columns(), Smoothed(Upscaled(Levels(amplitude))),
                    kSmallWindowPerSquare);
  for (cv::Point2d& pixel : corners.pixels) pixel = Down(pixel);
  return corners;
}

}  // namespace sprout::calibrate
