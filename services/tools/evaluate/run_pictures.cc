#include "services/tools/evaluate/run_pictures.h"

#include <fmt/core.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <utility>

#include "common/core/image.h"
#include "common/picture/color_map.h"
#include "common/picture/picture.h"
#include "common/picture/write_image.h"

namespace sprout::evaluate {
namespace {

void Write(const std::filesystem::path& path, const cv::Mat3b& picture) {
  if (const Result<void> written = WritePng(path, picture); !written) {
    throw std::runtime_error(written.error().text);
  }
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
    Write(folder_ / (scene.name + "_" + method.name + ".png"),
          DisparityPicture(FromPx(method.map_px), range_px,
                           scene.name + ", " + method.name + ": " + correct, &pair));
    titles_.push_back(method.name);
    error_titles_.push_back(method.name);
    row.push_back({FigureThumbnail(Colorize(method.map_px, range_px)), correct});
    error_row.push_back(
        {FigureThumbnail(ColorizeErrors(ErrorMap(method.map_px, truth, scene.nonoccluded))),
         correct});
  }
  titles_.push_back("ground truth");
  row.push_back({FigureThumbnail(Colorize(truth, range_px)), ""});
  // What lies beyond a scale has the colour of its end: there may be such pixels in any of the
  // maps.
  ScaleContent scale = DisparityScale(range_px, &pair);
  scale.above = scale.below = true;
  rows_.push_back({std::move(row), std::move(scale)});
  error_rows_.push_back(
      {std::move(error_row), {.axes = {{{0, kLargestErrorPx}, "px"}}, .above = true}});
}

void RunPictures::WriteFigures() const {
  Write(folder_ / "figure.png", Figure(titles_, rows_));
  Write(folder_ / "errors.png", Figure(error_titles_, error_rows_));
}

}  // namespace sprout::evaluate
