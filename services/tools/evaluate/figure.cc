#include "services/tools/evaluate/figure.h"

#include <algorithm>
#include <cassert>
#include <opencv2/imgproc.hpp>

#include "common/picture/text.h"

namespace sprout::evaluate {
namespace {

constexpr int kGap = 10;
constexpr int kCapHeight = 13;
constexpr int kScaleCapHeight = 9;
constexpr int kTextLine = 3 * kCapHeight;  // a line of text and the space around it
constexpr int kColumn = kFigureCellWidth + kGap;
const cv::Vec3b kPaper{255, 255, 255};
const cv::Vec3b kInk{24, 24, 24};

int ColumnLeft(size_t column) { return kGap + static_cast<int>(column) * kColumn; }

// Centred on a column, with the top of its line at `top`.
void DrawCentred(cv::Mat3b& sheet, const std::string& text, size_t column, int top) {
  int cap_height = kCapHeight;
  while (cap_height > 1 && TextWidth(text, cap_height) > kFigureCellWidth) --cap_height;
  const int left = ColumnLeft(column) + (kFigureCellWidth - TextWidth(text, cap_height)) / 2;
  DrawText(sheet, text, {left, top + 2 * kCapHeight}, cap_height, kInk);
}

// A row's pictures and their captions.
int RowHeight(const FigureRow& row) {
  return FigureThumbnail(row.cells.front().image).rows + kTextLine;
}

ColorScale ScaleOf(const FigureRow& row) {
  const int height = RowHeight(row) - kTextLine;
  const int cap_height = std::clamp(height / ColorScale::MinHeight(1), 1, kScaleCapHeight);
  return {row.scale, std::max(height, ColorScale::MinHeight(cap_height)), cap_height};
}

void DrawRow(cv::Mat3b& sheet, const FigureRow& row, int top) {
  for (size_t i = 0; i < row.cells.size(); ++i) {
    const cv::Mat3b thumbnail = FigureThumbnail(row.cells[i].image);
    thumbnail.copyTo(sheet(cv::Rect({ColumnLeft(i), top}, thumbnail.size())));
    DrawCentred(sheet, row.cells[i].caption, i, top + thumbnail.rows);
  }
  ScaleOf(row).Draw(sheet, {ColumnLeft(row.cells.size()), top}, top - kScaleCapHeight);
}

}  // namespace

cv::Mat3b FigureThumbnail(const cv::Mat3b& image) {
  assert(!image.empty());
  if (image.cols == kFigureCellWidth) return image;
  const int height = std::max(1, cvRound(double{kFigureCellWidth} * image.rows / image.cols));
  cv::Mat3b thumbnail;
  cv::resize(image, thumbnail, {kFigureCellWidth, height}, 0, 0, cv::INTER_AREA);
  return thumbnail;
}

cv::Mat3b Figure(const std::vector<std::string>& titles, const std::vector<FigureRow>& rows) {
  int height = kTextLine;
  int scale_width = 0;
  for (const FigureRow& row : rows) {
    height += RowHeight(row);
    scale_width = std::max(scale_width, ScaleOf(row).width());
  }
  cv::Mat3b sheet(height, ColumnLeft(titles.size()) + scale_width + kGap, kPaper);
  for (size_t i = 0; i < titles.size(); ++i) DrawCentred(sheet, titles[i], i, 0);
  int top = kTextLine;
  for (const FigureRow& row : rows) {
    DrawRow(sheet, row, top);
    top += RowHeight(row);
  }
  return sheet;
}

}  // namespace sprout::evaluate
