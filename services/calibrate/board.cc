#include "services/calibrate/board.h"

#include <cstdint>
#include <iomanip>
#include <locale>
#include <opencv2/aruco.hpp>
#include <sstream>

#include "common/config/config.h"

namespace sprout {
namespace {

// Of a square: 4 bits and a border on either side, and half of what is left on either side again.
constexpr double kMarkerPerSquare = 6.0 / Board::kModulesPerSquare;

// White paper around the pattern: a marker that ends at the edge of a dark table is not found.
constexpr double kMarginMm = 15;
constexpr double kFooterMm = 15;  // the ruler and two lines of text
constexpr double kTextMm = 3.5;   // height of letters

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

std::ostringstream Stream() {
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text << std::setprecision(8);
  return text;
}

// The longest of 1, 2 and 5 times a power of ten (mm) that fits.
double RoundLength(double at_most_mm) {
  double length = 1;
  for (int step = 0; length * (step % 3 == 1 ? 2.5 : 2) <= at_most_mm; ++step) {
    length *= step % 3 == 1 ? 2.5 : 2;
  }
  return length;
}

// One path for all of the black, so that no hairline shows between its parts.
std::string BlackPath(const cv::Mat1b& modules) {
  std::ostringstream path = Stream();
  for (int row = 0; row < modules.rows; ++row) {
    for (int begin = 0; begin < modules.cols;) {
      int end = begin;
      while (end < modules.cols && modules(row, end) == modules(row, begin)) ++end;
      if (modules(row, begin) == 0) {
        path << "M" << begin << " " << row << "h" << end - begin << "v1h" << begin - end << "z";
      }
      begin = end;
    }
  }
  return path.str();
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

std::string BoardSvg(const Board& board) {
  const Eigen::Vector2d extent_mm = 1000 * board.extent_m();
  const double square_mm = 1000 * board.size().square_m;
  const double width_mm = extent_mm.x() + 2 * kMarginMm;
  const double height_mm = extent_mm.y() + 2 * kMarginMm + kFooterMm;
  const double ruler_mm = RoundLength(extent_mm.x());
  const double ruler_y_mm = kMarginMm + extent_mm.y() + kMarginMm;

  std::ostringstream svg = Stream();
  svg << "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" << width_mm << "mm\" height=\""
      << height_mm << "mm\" viewBox=\"0 0 " << width_mm << " " << height_mm << "\">\n"
      << "<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n"
      << "<path transform=\"translate(" << kMarginMm << " " << kMarginMm << ") scale("
      << square_mm / Board::kModulesPerSquare << ")\" d=\"" << BlackPath(board.Modules())
      << "\"/>\n"
      << "<path fill=\"none\" stroke=\"black\" stroke-width=\"0.25\" d=\"M" << kMarginMm << " "
      << ruler_y_mm - 2 << "v4m0 -2h" << ruler_mm << "m0 -2v4\"/>\n"
      << "<text x=\"" << kMarginMm << "\" y=\"" << ruler_y_mm + 2 + kTextMm
      << "\" font-family=\"sans-serif\" font-size=\"" << kTextMm << "\">this line is " << ruler_mm
      << " mm long: print at 100 %</text>\n"
      << "<text x=\"" << kMarginMm << "\" y=\"" << ruler_y_mm + 2 + 2.5 * kTextMm
      << "\" font-family=\"sans-serif\" font-size=\"" << kTextMm << "\">sprout-calibrate --squares "
      << board.size().columns << "x" << board.size().rows << " --square-mm " << square_mm
      << "</text>\n</svg>\n";
  return svg.str();
}

}  // namespace sprout
