#include "services/tools/evaluate/run_pictures.h"

#include <fmt/core.h>

#include <algorithm>
#include <cassert>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "common/core/image.h"
#include "common/picture/color_map.h"
#include "common/picture/picture.h"
#include "common/picture/text.h"
#include "common/picture/write_image.h"

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

// Draws text centred on a column, with the top of its line at `top`.
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

std::string CorrectText(const MethodResult& method) {
  return fmt::format("{:.1f} %", method.nonoccluded.correct_le1_percent());
}

// The points of the ToF camera on the left image, and their number.
FigureCell PointsCell(const Scene& scene, const ValueRange& range_px) {
  constexpr double kDarkening = 0.45;  // the image stays recognisable, the points stand out
  cv::Mat3b picture = ToBgr(scene.left_grey * kDarkening);
  const int radius = std::max(1, picture.cols / (2 * kFigureCellWidth));  // a pixel in the figure
  int behind = 0;
  const std::vector<ProjectedPoint> points = scene.projector.Project(scene.frame.tof, behind);
  for (const ProjectedPoint& point : points) {
    cv::circle(picture, {cvRound(point.seed.u), cvRound(point.seed.v)}, radius,
               cv::Scalar(ColorOf(point.seed.disparity(), range_px)), cv::FILLED);
  }
  return {FigureThumbnail(picture), fmt::format("{} points", points.size())};
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

void RunPictures::Add(const Scene& scene, const SceneResult& result) {
  const cv::Mat1f& truth = scene.frame.truth.left;
  const ValueRange range_px = RobustRange({truth.begin(), truth.end()});
  const RectifiedPair& pair = scene.projector.rig().pair;
  titles_ = {"left image"};
  error_titles_ = {"left image", "ToF points"};
  std::vector<FigureCell> row{{FigureThumbnail(ToBgr(scene.frame.left)), scene.name}};
  std::vector<FigureCell> error_row{row.front(), PointsCell(scene, range_px)};
  for (const MethodResult& method : result.methods) {
    const std::string correct = CorrectText(method);
    RequireWritten(
        WritePng(folder_ / (scene.name + "_" + method.name + ".png"),
                 DisparityPicture(FromPx(method.map_px), range_px,
                                  scene.name + ", " + method.name + ": " + correct, &pair)));
    titles_.push_back(method.name);
    error_titles_.push_back(method.name);
    row.push_back({FigureThumbnail(Colorize(method.map_px, range_px)), correct});
    error_row.push_back(
        {FigureThumbnail(ColorizeErrors(ErrorMap(method.map_px, truth, scene.nonoccluded))),
         correct});
  }
  titles_.push_back("ground truth");
  row.push_back({FigureThumbnail(Colorize(truth, range_px)), ""});
  // The scale is drawn open at both ends: any of the maps may have pixels beyond it.
  ScaleContent scale = DisparityScale(range_px, &pair);
  scale.above = scale.below = true;
  rows_.push_back({std::move(row), std::move(scale)});
  error_rows_.push_back(
      {std::move(error_row), {.axes = {{{0, kLargestErrorPx}, "px"}}, .above = true}});
}

void RunPictures::WriteFigures() const {
  RequireWritten(WritePng(folder_ / "figure.png", Figure(titles_, rows_)));
  RequireWritten(WritePng(folder_ / "errors.png", Figure(error_titles_, error_rows_)));
}

}  // namespace sprout::evaluate
