#include "services/tools/calibrate/board.h"

#include <cairo-pdf.h>
#include <cairo-svg.h>
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <string_view>

#include "common/config/config_error.h"
#include "common/core/joined.h"

namespace sprout::calibrate {
namespace {

// OpenCV's dictionaries, in the order of their numbers.
constexpr std::array<std::string_view, 21> kDictionaries = {
    "DICT_4X4_50",         "DICT_4X4_100",       "DICT_4X4_250",       "DICT_4X4_1000",
    "DICT_5X5_50",         "DICT_5X5_100",       "DICT_5X5_250",       "DICT_5X5_1000",
    "DICT_6X6_50",         "DICT_6X6_100",       "DICT_6X6_250",       "DICT_6X6_1000",
    "DICT_7X7_50",         "DICT_7X7_100",       "DICT_7X7_250",       "DICT_7X7_1000",
    "DICT_ARUCO_ORIGINAL", "DICT_APRILTAG_16h5", "DICT_APRILTAG_25h9", "DICT_APRILTAG_36h10",
    "DICT_APRILTAG_36h11"};
static_assert(kDictionaries[cv::aruco::DICT_4X4_250] == "DICT_4X4_250" &&
              kDictionaries[cv::aruco::DICT_ARUCO_ORIGINAL] == "DICT_ARUCO_ORIGINAL" &&
              kDictionaries[cv::aruco::DICT_APRILTAG_36h11] == "DICT_APRILTAG_36h11");

// Requires that the dictionary has as many markers as the board needs.
void CheckMarkers(const BoardSize& size, int64_t needed, const std::string& dictionary) {
  const int there = OpenDictionary(dictionary).bytesList.rows;
  if (needed > there) {
    throw ConfigError(
        fmt::format("--squares {}x{}: allowed is what needs no more than the {} markers of {}",
                    size.columns, size.rows, there, dictionary));
  }
}

BoardSize Checked(const BoardSize& size) {
  const int64_t squares = int64_t{size.columns} * size.rows;
  const bool has_tags = size.kind == BoardKind::kAprilGrid;
  const int least = has_tags ? 2 : 3;
  constexpr int kMaxSquares = 500;
  if (size.columns < least || size.rows < least || squares > kMaxSquares) {
    throw ConfigError(fmt::format("--squares {}x{}: allowed is {}x{} and more, up to {} {} in all",
                                  size.columns, size.rows, least, least, kMaxSquares,
                                  has_tags ? "tags" : "squares"));
  }
  if (has_tags) CheckMarkers(size, squares, "DICT_APRILTAG_36h11");
  if (size.kind == BoardKind::kCharuco) CheckMarkers(size, squares / 2, size.dictionary);
  if (!(size.square_m >= 0.001 && size.square_m <= 10)) {
    throw ConfigError(
        fmt::format("--square-mm {:g}: allowed is a number from 1 to 10000", 1000 * size.square_m));
  }
  if (!(size.marker_per_square > 0.2 && size.marker_per_square < 1)) {
    throw ConfigError(fmt::format("--marker-mm {:g}: allowed is a fifth of a square to a square",
                                  1000 * size.square_m * size.marker_per_square));
  }
  if (!(size.gap_per_tag >= 0.1 && size.gap_per_tag <= 1)) {
    throw ConfigError(
        fmt::format("--tag-spacing {:g}: allowed is a number from 0.1 to 1", size.gap_per_tag));
  }
  return size;
}

// White paper around the pattern: a marker that ends at the edge of a dark table is not found.
constexpr double kMarginMm = 15;
constexpr double kFooterMm = 15;  // the ruler and two lines of text
constexpr double kTextMm = 3.5;   // height of letters
constexpr double kPointsPerMm = 72 / 25.4;

using Surface = std::unique_ptr<cairo_surface_t, decltype(&cairo_surface_destroy)>;
using Pen = std::unique_ptr<cairo_t, decltype(&cairo_destroy)>;

cairo_status_t Append(void* text, const unsigned char* data, unsigned int size) {
  static_cast<std::string*>(text)->append(reinterpret_cast<const char*>(data), size);
  return CAIRO_STATUS_SUCCESS;
}

Surface MakeSurface(const std::filesystem::path& path, const Eigen::Vector2d& page_mm,
                    std::string& bytes) {
  const Eigen::Vector2d points = kPointsPerMm * page_mm;
  cairo_surface_t* surface = nullptr;
  if (path.extension() == ".pdf") {
    surface = cairo_pdf_surface_create_for_stream(&Append, &bytes, points.x(), points.y());
    cairo_pdf_surface_set_metadata(surface, CAIRO_PDF_METADATA_CREATE_DATE, nullptr);
  } else if (path.extension() == ".svg") {
    surface = cairo_svg_surface_create_for_stream(&Append, &bytes, points.x(), points.y());
    // Cairo's default unit depends on its version.
    cairo_svg_surface_set_document_unit(surface, CAIRO_SVG_UNIT_PT);
  } else {
    throw ConfigError("--out " + path.string() + ": allowed is a name that ends in .pdf or .svg");
  }
  return {surface, &cairo_surface_destroy};
}

// The longest of 1, 2 and 5 times a power of ten (mm) that fits.
double RoundLength(double at_most_mm) {
  double length = 1;
  for (int step = 0; length * (step % 3 == 1 ? 2.5 : 2) <= at_most_mm; ++step) {
    length *= step % 3 == 1 ? 2.5 : 2;
  }
  return length;
}

// All of the black in one fill, so that no hairline shows between its parts.
void DrawPattern(cairo_t* pen, const cv::Mat1b& modules, double module_mm) {
  for (int row = 0; row < modules.rows; ++row) {
    for (int begin = 0; begin < modules.cols;) {
      int end = begin;
      while (end < modules.cols && modules(row, end) == modules(row, begin)) ++end;
      if (modules(row, begin) == 0) {
        cairo_rectangle(pen, kMarginMm + begin * module_mm, kMarginMm + row * module_mm,
                        (end - begin) * module_mm, module_mm);
      }
      begin = end;
    }
  }
  cairo_fill(pen);
}

void DrawRuler(cairo_t* pen, double y_mm, double length_mm) {
  cairo_set_line_width(pen, 0.25);
  cairo_move_to(pen, kMarginMm, y_mm - 2);
  cairo_rel_line_to(pen, 0, 4);
  cairo_rel_move_to(pen, 0, -2);
  cairo_rel_line_to(pen, length_mm, 0);
  cairo_rel_move_to(pen, 0, -2);
  cairo_rel_line_to(pen, 0, 4);
  cairo_stroke(pen);
}

void DrawText(cairo_t* pen, double y_mm, const std::string& text) {
  cairo_select_font_face(pen, "sans-serif", CAIRO_FONT_SLANT_NORMAL, CAIRO_FONT_WEIGHT_NORMAL);
  cairo_set_font_size(pen, kTextMm);
  cairo_move_to(pen, kMarginMm, y_mm);
  cairo_show_text(pen, text.c_str());
}

}  // namespace

aruco::Dictionary OpenDictionary(const std::string& name) {
  const auto found = std::ranges::find(kDictionaries, name);
  if (found == kDictionaries.end()) {
    throw ConfigError("--dictionary " + name + ": allowed is one of " +
                      Joined(", ", kDictionaries));
  }
  return aruco::OpenDictionary(static_cast<int>(found - kDictionaries.begin()));
}

std::string BoardText(const BoardSize& size) {
  const std::string extent = fmt::format("{}x{}", size.columns, size.rows);
  switch (size.kind) {
    case BoardKind::kCharuco:
      return "ChArUco board of " + extent + " squares with " + size.dictionary;
    case BoardKind::kChessboard:
      return fmt::format("chessboard of {} squares, {}x{} inner corners", extent, size.columns - 1,
                         size.rows - 1);
    case BoardKind::kAprilGrid:
      break;
  }
  return "AprilGrid of " + extent + " tags";
}

Board::Board(const BoardSize& size) : size_(Checked(size)) {
  const double side = size.square_m;
  if (size.kind == BoardKind::kAprilGrid) {
    corner_columns_ = 2 * size.columns;
    const double pitch = side * (1 + size.gap_per_tag);
    for (int row = 0; row < 2 * size.rows; ++row) {
      for (int column = 0; column < corner_columns_; ++column) {
        corners_.emplace_back(column / 2 * pitch + column % 2 * side,
                              row / 2 * pitch + row % 2 * side, 0);
      }
    }
    return;
  }
  if (size.kind == BoardKind::kCharuco) {
    charuco_ = aruco::MakeCharuco({size.columns, size.rows}, side, side * size.marker_per_square,
                                  OpenDictionary(size.dictionary));
  }
  corner_columns_ = size.columns - 1;
  for (int row = 1; row < size.rows; ++row) {
    for (int column = 1; column < size.columns; ++column) {
      corners_.emplace_back(column * side, row * side, 0);
    }
  }
}

Eigen::Vector2d Board::extent_m() const {
  const double pitch =
      size_.square_m * (size_.kind == BoardKind::kAprilGrid ? 1 + size_.gap_per_tag : 1);
  return {size_.columns * pitch, size_.rows * pitch};
}

cv::Mat1b Board::Modules() const {
  // OpenCV places markers on whole pixels, so it draws several a module, of which the middle is
  // taken.
  constexpr int kPixels = 5;
  const cv::Size size(size_.columns * kModulesPerSquare, size_.rows * kModulesPerSquare);
  cv::Mat1b modules;
  cv::resize(aruco::Draw(charuco_, size * kPixels), modules, size, 0, 0, cv::INTER_NEAREST_EXACT);
  return modules;
}

Eigen::Vector2d BoardPageSizeMm(const Board& board) {
  const Eigen::Vector2d extent_mm = 1000 * board.extent_m();
  return {extent_mm.x() + 2 * kMarginMm, extent_mm.y() + 2 * kMarginMm + kFooterMm};
}

std::string BoardPage(const Board& board, const std::filesystem::path& path) {
  const Eigen::Vector2d extent_mm = 1000 * board.extent_m();
  const double square_mm = 1000 * board.size().square_m;
  const Eigen::Vector2d page_mm = BoardPageSizeMm(board);
  const double ruler_mm = RoundLength(extent_mm.x());
  const double ruler_y_mm = 2 * kMarginMm + extent_mm.y();

  std::string bytes;
  const Surface surface = MakeSurface(path, page_mm, bytes);
  const Pen pen(cairo_create(surface.get()), &cairo_destroy);
  cairo_scale(pen.get(), kPointsPerMm, kPointsPerMm);
  cairo_set_source_rgb(pen.get(), 1, 1, 1);
  cairo_paint(pen.get());
  cairo_set_source_rgb(pen.get(), 0, 0, 0);
  DrawPattern(pen.get(), board.Modules(), square_mm / Board::kModulesPerSquare);
  DrawRuler(pen.get(), ruler_y_mm, ruler_mm);
  DrawText(pen.get(), ruler_y_mm + 2 + kTextMm,
           fmt::format("this line is {:g} mm long: print at 100 %", ruler_mm));
  DrawText(pen.get(), ruler_y_mm + 2 + 2.5 * kTextMm,
           fmt::format("sprout-calibrate --squares {}x{} --square-mm {:g}", board.size().columns,
                       board.size().rows, square_mm));
  cairo_surface_finish(surface.get());
  if (const auto status = cairo_status(pen.get()); status != CAIRO_STATUS_SUCCESS) {
    throw std::runtime_error(path.string() + ": " + cairo_status_to_string(status));
  }
  return bytes;
}

}  // namespace sprout::calibrate
