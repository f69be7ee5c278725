#include "services/evaluate/figure.h"

#include <algorithm>
#include <cassert>
#include <opencv2/imgproc.hpp>

#include "common/picture/text.h"

namespace sprout {
namespace {

constexpr int kGap = 10;
constexpr int kCapHeight = 13;
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
int RowHeight(const std::vector<FigureCell>& row) {
  return FigureThumbnail(row.front().image).rows + kTextLine;
}

void DrawRow(cv::Mat3b& sheet, const std::vector<FigureCell>& row, int top) {
  for (size_t i = 0; i < row.size(); ++i) {
    const cv::Mat3b thumbnail = FigureThumbnail(row[i].image);
    thumbnail.copyTo(sheet(cv::Rect({ColumnLeft(i), top}, thumbnail.size())));
    DrawCentred(sheet, row[i].caption, i, top + thumbnail.rows);
  }
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

cv::Mat3b Figure(const std::vector<std::string>& titles,
                 const std::vector<std::vector<FigureCell>>& rows) {
  int height = kTextLine;
  for (const auto& row : rows) height += RowHeight(row);
  cv::Mat3b sheet(height, ColumnLeft(titles.size()), kPaper);
  for (size_t i = 0; i < titles.size(); ++i) DrawCentred(sheet, titles[i], i, 0);
  int top = kTextLine;
  for (const auto& row : rows) {
    DrawRow(sheet, row, top);
    top += RowHeight(row);
  }
  return sheet;
}

}  // namespace sprout
