#ifndef SPROUT_SERVICES_CALIBRATE_BOARD_H_
#define SPROUT_SERVICES_CALIBRATE_BOARD_H_

#include <Eigen/Core>
#include <opencv2/aruco/charuco.hpp>
#include <opencv2/core.hpp>
#include <vector>

namespace sprout::calibrate {

/// The printed board: a chessboard with a marker in each white square, so that a visible part of it
/// can be identified.
struct BoardSize {
  int columns = 9;          ///< squares
  int rows = 6;             ///< squares
  double square_m = 0.060;  ///< side of a square as measured on the print
};

/// A ChArUco board: markers of 4 × 4 bits (OpenCV's dictionary DICT_4X4_250) and a border of one
/// bit, three quarters of a square wide, so that a square is 8 × 8 modules of one size.
class Board {
 public:
  static constexpr int kModulesPerSquare = 8;
  static constexpr int kMaxMarkers = 250;

  /// @throws ConfigError when there are fewer than 3 × 3 squares, more markers than the dictionary
  ///         has, or squares without a size.
  explicit Board(const BoardSize& size);

  const BoardSize& size() const { return size_; }

  /// Inner corners of the chessboard, numbered as OpenCV does.
  int corner_count() const { return static_cast<int>(corners_.size()); }

  /// Position of a corner on the board, m: x right, y down from the pattern's upper left corner
  /// as it is printed, z = 0 (z points away from the viewer).
  const Eigen::Vector3d& corner(int id) const { return corners_[static_cast<size_t>(id)]; }

  /// Width and height of the pattern, m.
  Eigen::Vector2d extent_m() const {
    return {size_.columns * size_.square_m, size_.rows * size_.square_m};
  }

  /// The pattern, one pixel a module: 0 or 255.
  cv::Mat1b Modules() const;

  const cv::Ptr<cv::aruco::CharucoBoard>& charuco() const { return charuco_; }

 private:
  BoardSize size_;
  cv::Ptr<cv::aruco::CharucoBoard> charuco_;
  std::vector<Eigen::Vector3d> corners_;
};

}  // namespace sprout::calibrate

#endif  // SPROUT_SERVICES_CALIBRATE_BOARD_H_
