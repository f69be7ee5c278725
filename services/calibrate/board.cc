#include "services/calibrate/board.h"

#include <cstdint>
#include <opencv2/aruco.hpp>
#include <sstream>
#include <string>

#include "common/config/config_error.h"

namespace sprout::calibrate {
namespace {

// Of a square: 4 bits and a border on either side, and half of what is left on either side again.
constexpr double kMarkerPerSquare = 6.0 / Board::kModulesPerSquare;

BoardSize Checked(const BoardSize& size) {
  const int64_t squares = int64_t{size.columns} * size.rows;
  if (size.columns < 3 || size.rows < 3 || squares / 2 > Board::kMaxMarkers) {
    throw ConfigError("--squares " + std::to_string(size.columns) + "x" +
                      std::to_string(size.rows) + ": allowed is 3x3 and more, up to " +
                      std::to_string(2 * Board::kMaxMarkers) + " squares in all");
  }
  if (!(size.square_m >= 0.001 && size.square_m <= 10)) {
    std::ostringstream value;
    value << 1000 * size.square_m;
    throw ConfigError("--square-mm " + value.str() + ": allowed is a number from 1 to 10000");
  }
  return size;
}

}  // namespace

Board::Board(const BoardSize& size)
    : size_(Checked(size)),
      charuco_(cv::aruco::CharucoBoard::create(
          size.columns, size.rows, static_cast<float>(size.square_m),
          static_cast<float>(size.square_m * kMarkerPerSquare),
          cv::aruco::getPredefinedDictionary(cv::aruco::DICT_4X4_250))) {
  corners_.reserve(static_cast<size_t>((size.columns - 1) * (size.rows - 1)));
  for (int row = 1; row < size.rows; ++row) {
    for (int column = 1; column < size.columns; ++column) {
      corners_.emplace_back(column * size.square_m, row * size.square_m, 0);
    }
  }
}

cv::Mat1b Board::Modules() const {
  // OpenCV places markers to a pixel, so each module gets several, of which the middle one counts.
  constexpr int kPixels = 5;
  cv::Mat1b modules(size_.rows * kModulesPerSquare, size_.columns * kModulesPerSquare);
  cv::Mat1b picture;
  charuco_->draw(modules.size() * kPixels, picture, 0, 1);
  for (int row = 0; row < modules.rows; ++row) {
    for (int column = 0; column < modules.cols; ++column) {
      modules(row, column) = picture(row * kPixels + kPixels / 2, column * kPixels + kPixels / 2);
    }
  }
  return modules;
}

}  // namespace sprout::calibrate
