#include "services/tools/calibrate/board_page.h"

#include <cairo-pdf.h>
#include <cairo-svg.h>
#include <fmt/core.h>

#include <memory>
#include <stdexcept>

#include "common/config/config_error.h"

namespace sprout::calibrate {
namespace {

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
    // What Cairo writes without this depends on its version; a number without a unit is in pixels.
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
