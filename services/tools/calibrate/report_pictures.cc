#include "services/tools/calibrate/report_pictures.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "common/core/image.h"
#include "common/geometry/projection.h"
#include "common/picture/color_map.h"
#include "common/picture/picture.h"

namespace sprout::calibrate {
namespace {

constexpr int kCoverageWidth = 480;
constexpr int kPairWidth = 1400;
constexpr int kTofWidth = 1000;
constexpr double kDarker = 0.7;  // so that dots stand out
constexpr int kRows = 16;
const cv::Scalar kRowColor(60, 200, 60);
const cv::Scalar kGridColor(190, 190, 190);
// Sub-pixel positions of OpenCV's drawing: of 1/16 px.
constexpr int kShift = 4;

cv::Point Fixed(const cv::Point2d& p) {
  return {static_cast<int>(std::lround(p.x * (1 << kShift))),
          static_cast<int>(std::lround(p.y * (1 << kShift)))};
}

cv::Mat3b ToColor(const cv::Mat& image) {
  cv::Mat3b color;
  cv::cvtColor(ToGrey(image), color, cv::COLOR_GRAY2BGR);
  return color;
}

cv::Mat3b ToWidth(const cv::Mat3b& picture, int width) {
  if (picture.cols <= width) return picture;
  cv::Mat3b small;
  cv::resize(picture, small, {width, picture.rows * width / picture.cols}, 0, 0, cv::INTER_AREA);
  return small;
}

cv::Mat3b Darkened(const cv::Mat& image, int width) {
  cv::Mat3b picture;
  ToWidth(ToColor(image), width).convertTo(picture, -1, kDarker);
  return picture;
}

}  // namespace

cv::Mat3b CoveragePicture(const CameraQuality& quality, cv::Size size) {
  const double scale = static_cast<double>(kCoverageWidth) / size.width;
  cv::Mat3b picture(static_cast<int>(std::lround(size.height * scale)), kCoverageWidth,
                    cv::Vec3b(255, 255, 255));
  for (int part = 1; part < 3; ++part) {
    const int x = picture.cols * part / 3;
    const int y = picture.rows * part / 3;
    cv::line(picture, {x, 0}, {x, picture.rows}, kGridColor);
    cv::line(picture, {0, y}, {picture.cols, y}, kGridColor);
  }
  cv::rectangle(picture, cv::Rect({0, 0}, picture.size()), kGridColor);
  // rms_px is of both coordinates together.
  const ValueRange range_px{0, std::max(1e-6, 4 * quality.rms_px / std::sqrt(2.0))};
  bool clipped = false;
  for (const CornerResidual& residual : quality.residuals) {
    clipped = clipped || cv::norm(residual.error) > range_px.max;
    const cv::Vec3b color = ColorOf(cv::norm(residual.error), range_px);
    const cv::Point2d centre = (residual.pixel + cv::Point2d(0.5, 0.5)) * scale;
    cv::circle(picture, Fixed(centre), 2 << kShift, cv::Scalar(color[0], color[1], color[2]),
               cv::FILLED, cv::LINE_AA, kShift);
  }
  return ScaledPicture(picture, "", {.axes = {{range_px, "px"}}, .above = clipped});
}

cv::Mat3b PairPicture(const cv::Mat& left, const cv::Mat& right) {
  cv::Mat3b both;
  cv::hconcat(ToColor(left), ToColor(right), both);
  both = ToWidth(both, kPairWidth);
  for (int row = 1; row < kRows; ++row) {
    const int y = both.rows * row / kRows;
    cv::line(both, {0, y}, {both.cols, y}, kRowColor);
  }
  return both;
}

cv::Mat3b TofPicture(const cv::Mat& left, const TofImage& tof, const Rig& rig) {
  cv::Mat3b picture = Darkened(left, kTofWidth);
  const double scale = static_cast<double>(picture.cols) / left.cols;
  const ValueRange range_m = DepthRange(tof);
  ScaleContent content{.axes = {{range_m, "m", /*is_depth=*/true}}};
  int behind = 0;
  for (const ProjectedPoint& point : TofProjector(rig).Project(tof, behind)) {
    const float depth_m = tof.depth_m(point.tof_v, point.tof_u);
    const cv::Vec3b color = ColorOfDepth(depth_m, range_m);
    const cv::Point2d pixel(point.seed.u, point.seed.v);
    if (!cv::Rect2d({0, 0}, cv::Size2d(left.size())).contains(pixel)) continue;
    content.above = content.above || depth_m < range_m.min;  // near is up
    content.below = content.below || depth_m > range_m.max;
    cv::circle(picture, Fixed((pixel + cv::Point2d(0.5, 0.5)) * scale), 3 << (kShift - 1),
               cv::Scalar(color[0], color[1], color[2]), cv::FILLED, cv::LINE_AA, kShift);
  }
  return ScaledPicture(picture, "", content);
}

cv::Mat3b DotsPicture(const cv::Mat& image, const std::vector<cv::Point2d>& places,
                      const std::vector<double>& values_px, double most_px) {
  cv::Mat3b picture = Darkened(image, kPairWidth / 2);
  const double scale = static_cast<double>(picture.cols) / image.cols;
  const ValueRange range_px{0, most_px};
  bool clipped = false;
  for (size_t i = 0; i < places.size(); ++i) {
    const cv::Vec3b color = ColorOf(values_px[i], range_px);
    clipped = clipped || values_px[i] > most_px;
    cv::circle(picture, Fixed((places[i] + cv::Point2d(0.5, 0.5)) * scale), 2 << kShift,
               cv::Scalar(color[0], color[1], color[2]), cv::FILLED, cv::LINE_AA, kShift);
  }
  return ScaledPicture(picture, "", {.axes = {{range_px, "px"}}, .above = clipped});
}

}  // namespace sprout::calibrate
