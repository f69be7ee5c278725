#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <map>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "services/tools/calibrate/board_finder.h"

namespace sprout::calibrate {
namespace {

using aruco::Quad;

// Whether markers lie as on the board: but for the lens's distortion, one homography maps most of
// them from the board to the image.
bool LieAsOn(const aruco::CharucoBoard& board, const std::vector<Quad>& markers,
             const std::vector<int>& ids) {
  constexpr double kMaxOffPerSide =
      0.5;  // of a marker; on another board they are whole squares off
  const auto& on_this = aruco::MarkersOf(board);
  std::vector<cv::Point2f> on_board;
  std::vector<cv::Point2f> in_image;
  double side = 0;
  int of_board = 0;
  for (size_t i = 0; i < ids.size(); ++i) {
    if (std::cmp_greater_equal(ids[i], on_this.size())) continue;
    for (const cv::Point3f& corner : on_this[static_cast<size_t>(ids[i])]) {
      on_board.emplace_back(corner.x, corner.y);
    }
    in_image.insert(in_image.end(), markers[i].begin(), markers[i].end());
    side += cv::norm(markers[i][1] - markers[i][0]);
    ++of_board;
  }
  if (of_board == 0) return false;
  side /= of_board;
  std::vector<uchar> fits;
  cv::findHomography(on_board, in_image, fits, cv::RANSAC, kMaxOffPerSide * side);
  return 2 * std::ranges::count(fits, 1) >= std::ssize(ids) * 4;
}

// OpenCV's corners are half a pixel off, and inaccurate where few markers were found.
BoardCorners ReadCharuco(const Board& board, const cv::Mat1b& image) {
  std::vector<Quad> markers;
  std::vector<int> marker_ids;
  const cv::Ptr<aruco::CharucoBoard>& charuco = board.charuco();
  aruco::FindMarkers(image, aruco::DictionaryOf(*charuco), markers, marker_ids);
  if (marker_ids.empty()) return {};
  BoardCorners corners{.markers = static_cast<int>(marker_ids.size())};
  if (!LieAsOn(*charuco, markers, marker_ids)) return corners;
  std::vector<cv::Point2f> pixels;
  std::vector<int> ids;
  aruco::FindCorners(image, charuco, markers, marker_ids, pixels, ids);
  std::map<int, cv::Point2d> sorted;
  for (size_t i = 0; i < ids.size(); ++i) sorted[ids[i]] = pixels[i];
  for (const auto& [id, pixel] : sorted) {
    corners.ids.push_back(id);
    corners.pixels.push_back(pixel);
  }
  return corners;
}

// --- Chessboards ---

double MeanAround(const cv::Mat1b& image, const cv::Point2f& p) {
  const cv::Rect window =
      cv::Rect(cv::Point(p) - cv::Point(1, 1), cv::Size(3, 3)) & cv::Rect({0, 0}, image.size());
  return window.empty() ? 0 : cv::mean(image(window))[0];
}

// Squares between the inner corners that are black when the board's upper left square is, less
// those that are white then: mean grey levels.
double Brightness(const cv::Mat1b& image, cv::Size inner, const std::vector<cv::Point2f>& pixels) {
  double sums[2] = {};
  int counts[2] = {};
  for (int row = 0; row + 1 < inner.height; ++row) {
    for (int column = 0; column + 1 < inner.width; ++column) {
      const auto i = static_cast<size_t>(row * inner.width + column);
      const cv::Point2f middle =
          (pixels[i] + pixels[i + 1] + pixels[i + static_cast<size_t>(inner.width)] +
           pixels[i + static_cast<size_t>(inner.width) + 1]) /
          4;
      sums[(row + column) % 2] += MeanAround(image, middle);
      ++counts[(row + column) % 2];
    }
  }
  return sums[0] / std::max(counts[0], 1) - sums[1] / std::max(counts[1], 1);
}

// Puts the corners into the order of the board. @returns false when it cannot be told.
bool Order(const cv::Mat1b& image, cv::Size inner, std::vector<cv::Point2f>& pixels) {
  const bool is_square = inner.width == inner.height;
  const float min_slope = is_square ? 0.77F : 0.2F;  // of a row's length, to the right
  const auto width = static_cast<size_t>(inner.width);
  const cv::Point2f first_row = pixels[width - 1] - pixels[0];
  if (is_square && std::abs(first_row.y) > std::abs(first_row.x)) {  // OpenCV began with a column
    cv::Mat grid(inner, CV_32FC2, pixels.data());
    cv::transpose(grid, grid);
  }
  const cv::Point2f along = pixels[width - 1] - pixels[0];
  const cv::Point2f down = pixels[pixels.size() - width] - pixels[0];
  if (along.cross(down) < 0) {  // seen in a mirror: rows the other way round
    for (size_t row = 0; row < pixels.size(); row += width) {
      std::reverse(pixels.begin() + static_cast<std::ptrdiff_t>(row),
                   pixels.begin() + static_cast<std::ptrdiff_t>(row + width));
    }
  }
  const bool colours_tell = (inner.width + inner.height) % 2 != 0;
  const cv::Point2f row = pixels[width - 1] - pixels[0];
  const auto length = static_cast<float>(cv::norm(row));
  if (!colours_tell && std::abs(row.x) < min_slope * length) return false;
  if (colours_tell ? Brightness(image, inner, pixels) > 0 : row.x < 0) {
    std::ranges::reverse(pixels);
  }
  return true;
}

BoardCorners ReadChessboard(const Board& board, const cv::Mat1b& image) {
  const cv::Size inner(board.size().columns - 1, board.size().rows - 1);
  std::vector<cv::Point2f> pixels;
  const bool is_found =
      cv::findChessboardCorners(image, inner, pixels,
                                cv::CALIB_CB_ADAPTIVE_THRESH | cv::CALIB_CB_NORMALIZE_IMAGE) ||
      cv::findChessboardCornersSB(image, inner, pixels, cv::CALIB_CB_NORMALIZE_IMAGE);
  BoardCorners corners;
  if (!is_found || !Order(image, inner, pixels)) return corners;
  for (int id = 0; id < board.corner_count(); ++id) corners.ids.push_back(id);
  corners.pixels.assign(pixels.begin(), pixels.end());
  return corners;
}

// --- AprilGrids ---

// Tags with a border of so many bits: Kalibr's have two. The small squares that touch their corners
// are torn off by widening what is white.
std::pair<std::vector<int>, std::vector<Quad>> FindTags(const cv::Mat1b& image) {
  std::vector<int> best_ids;
  std::vector<Quad> best;
  const auto dictionary = aruco::OpenDictionary(cv::aruco::DICT_APRILTAG_36h11);
  for (const int wider : {0, 1, 2}) {
    cv::Mat1b torn;
    cv::dilate(image, torn, cv::Mat(), {-1, -1}, wider);
    for (const int border : {2, 1}) {
      std::vector<Quad> tags;
      std::vector<int> ids;
      aruco::FindMarkers(torn, dictionary, tags, ids, border);
      if (ids.size() > best_ids.size()) {
        best_ids = std::move(ids);
        best = std::move(tags);
      }
    }
  }
  return {best_ids, best};
}

cv::Point2f MiddleOf(const Quad& quad) { return (quad[0] + quad[1] + quad[2] + quad[3]) / 4; }

// Tags are counted from the lower left one to the right and upwards, as Kalibr does. How a tag
// itself is turned is not used: where its corners are is told by all tags together.
BoardCorners ReadAprilGrid(const Board& board, const cv::Mat1b& image) {
  constexpr size_t kMinTags = 4;
  constexpr double kMaxOffPerGap = 1;  // of a tag's middle from where the others say it is
  const BoardSize& size = board.size();
  const auto [ids, tags] = FindTags(image);
  BoardCorners corners{.markers = static_cast<int>(ids.size())};
  const double pitch = size.square_m * (1 + size.gap_per_tag);
  std::vector<cv::Point2f> on_board;
  std::vector<cv::Point2f> in_image;
  std::vector<int> first_corners;  // of each tag, its upper left one
  double side_px = 0;
  for (size_t i = 0; i < ids.size(); ++i) {
    if (ids[i] >= size.columns * size.rows) continue;
    const int column = ids[i] % size.columns;
    const int row = size.rows - 1 - ids[i] / size.columns;
    on_board.emplace_back(static_cast<float>(column * pitch + size.square_m / 2),
                          static_cast<float>(row * pitch + size.square_m / 2));
    in_image.push_back(MiddleOf(tags[i]));
    first_corners.push_back(2 * row * board.corner_columns() + 2 * column);
    side_px += cv::norm(tags[i][1] - tags[i][0]);
  }
  if (on_board.size() < kMinTags) return corners;
  side_px /= static_cast<double>(on_board.size());
  std::vector<uchar> fits;
  const cv::Mat1d image_from_board = cv::findHomography(on_board, in_image, fits, cv::RANSAC,
                                                        kMaxOffPerGap * size.gap_per_tag * side_px);
  const bool is_seen = !image_from_board.empty() && cv::determinant(image_from_board) > 0 &&
                       2 * static_cast<size_t>(std::ranges::count(fits, 1)) >= ids.size() &&
                       static_cast<size_t>(std::ranges::count(fits, 1)) >= kMinTags;
  if (!is_seen) return corners;
  std::map<int, cv::Point2d> sorted;
  for (size_t i = 0; i < first_corners.size(); ++i) {
    if (fits[i] == 0) continue;
    for (const int next : {0, 1, board.corner_columns(), board.corner_columns() + 1}) {
      const int id = first_corners[i] + next;
      const std::vector<cv::Point2d> place{{board.corner(id).x(), board.corner(id).y()}};
      std::vector<cv::Point2d> pixel;
      cv::perspectiveTransform(place, pixel, image_from_board);
      sorted[id] = pixel[0];
    }
  }
  for (const auto& [id, pixel] : sorted) {
    corners.ids.push_back(id);
    corners.pixels.push_back(pixel);
  }
  return corners;
}

}  // namespace

BoardCorners ReadBoard(const Board& board, const cv::Mat1b& image) {
  if (image.empty()) return {};
  switch (board.size().kind) {
    case BoardKind::kChessboard:
      return ReadChessboard(board, image);
    case BoardKind::kAprilGrid:
      return ReadAprilGrid(board, image);
    case BoardKind::kCharuco:
      break;
  }
  return ReadCharuco(board, image);
}

std::string SeenBoards(const std::vector<cv::Mat1b>& images) {
  // A larger dictionary begins with the smaller ones of the same number of bits.
  constexpr std::array kLargestDictionaries = {
      "DICT_4X4_250",        "DICT_5X5_250",       "DICT_6X6_250",       "DICT_7X7_250",
      "DICT_4X4_1000",       "DICT_5X5_1000",      "DICT_6X6_1000",      "DICT_7X7_1000",
      "DICT_ARUCO_ORIGINAL", "DICT_APRILTAG_16h5", "DICT_APRILTAG_25h9", "DICT_APRILTAG_36h11"};
  constexpr size_t kMinMarkers = 4;
  std::string text;
  size_t most = kMinMarkers - 1;
  const auto take = [&](size_t count, const std::string& what) {
    if (count <= most) return;
    most = count;
    text = fmt::format("{} {}", count, what);
  };
  for (const cv::Mat1b& image : images) {
    for (const char* name : kLargestDictionaries) {
      std::vector<Quad> markers;
      std::vector<int> ids;
      aruco::FindMarkers(image, OpenDictionary(name), markers, ids);
      take(ids.size(), std::string("markers of ") + name);
    }
    take(FindTags(image).first.size(), "tags of an AprilGrid");
  }
  if (!text.empty()) return text;  // the squares of a ChArUco board are a chessboard's, too
  for (const cv::Mat1b& image : images) {
    cv::Mat seen;
    std::vector<cv::Point2f> pixels;
    constexpr int kFlags = cv::CALIB_CB_NORMALIZE_IMAGE | cv::CALIB_CB_LARGER;
    if (!cv::findChessboardCornersSB(image, {3, 3}, pixels, kFlags, seen)) continue;
    take(pixels.size(),
         fmt::format("corners of a chessboard of {}x{} squares", std::max(seen.cols, seen.rows) + 1,
                     std::min(seen.cols, seen.rows) + 1));
  }
  return text;
}

}  // namespace sprout::calibrate
