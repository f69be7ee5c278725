#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "services/tools/calibrate/aruco.h"

namespace sprout::calibrate {

/// What is printed on a board.
enum class BoardKind {
  kCharuco,     ///< a chessboard with a marker in each white square
  kChessboard,  ///< without; seen as a whole or not at all
  kAprilGrid,   ///< Kalibr's: AprilTags in rows, small black squares where their corners meet
};

/// The printed board. One with markers can be identified by a visible part.
struct BoardSize {
  BoardKind kind = BoardKind::kCharuco;
  int columns = 9;                          ///< squares; of an AprilGrid tags
  int rows = 6;                             ///< squares; of an AprilGrid tags
  double square_m = 0.060;                  ///< side of a square or tag as measured on the print
  std::string dictionary = "DICT_4X4_250";  ///< of a ChArUco board's markers, by OpenCV's name
  double marker_per_square = 0.75;          ///< side of a ChArUco board's markers, of a square's
  double gap_per_tag = 0.3;                 ///< between tags of an AprilGrid, of a tag's side
};

/// "ChArUco board of 9x6 squares with DICT_4X4_250".
std::string BoardText(const BoardSize& size);

/// OpenCV's dictionary of this name. @throws ConfigError when there is none.
aruco::Dictionary OpenDictionary(const std::string& name);

/// A calibration board. The one that is printed here is a ChArUco board: markers of 4 × 4 bits
/// (OpenCV's dictionary DICT_4X4_250) and a border of one bit, three quarters of a square wide, so
/// that a square is 8 × 8 modules of one size.
class Board {
 public:
  static constexpr int kModulesPerSquare = 8;

  /// @throws ConfigError when there are fewer than 3 × 3 squares (2 × 2 tags), more markers than
  ///         the dictionary has, or squares without a size.
  explicit Board(const BoardSize& size);

  const BoardSize& size() const { return size_; }

  /// Inner corners of the chessboard, or the corners of all tags, row by row.
  int corner_count() const { return static_cast<int>(corners_.size()); }

  /// Corners in a row.
  int corner_columns() const { return corner_columns_; }

  /// Position of a corner on the board, m: x right, y down from the pattern's upper left corner
  /// as it is printed, z = 0 (z points away from the viewer).
  const Eigen::Vector3d& corner(int id) const { return corners_[static_cast<size_t>(id)]; }

  /// Width and height of the pattern, m.
  Eigen::Vector2d extent_m() const;

  /// The pattern, one pixel a module: 0 or 255. @pre it is the one that is printed here.
  cv::Mat1b Modules() const;

  /// Null unless it is a ChArUco board.
  const cv::Ptr<aruco::CharucoBoard>& charuco() const { return charuco_; }

 private:
  BoardSize size_;
  cv::Ptr<aruco::CharucoBoard> charuco_;
  std::vector<Eigen::Vector3d> corners_;
  int corner_columns_ = 0;
};

/// The board as a page at true scale: the pattern, a line of a round length to check the print
/// with, and the flags of `sprout-calibrate` for this board. The same board gives the same
/// bytes.
///
/// @param path its suffix chooses the format; nothing is written
/// @return     a PDF or SVG file's content
/// @throws ConfigError for another suffix than .pdf or .svg
std::string BoardPage(const Board& board, const std::filesystem::path& path);

/// Width and height of the page, mm: the pattern with its margin, and the line below.
Eigen::Vector2d BoardPageSizeMm(const Board& board);

}  // namespace sprout::calibrate
