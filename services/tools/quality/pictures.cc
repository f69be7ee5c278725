#include "services/tools/quality/pictures.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "common/picture/color_map.h"
#include "common/picture/picture.h"

namespace sprout::quality {
namespace {

constexpr int kMinSide = 240;  // px; smaller regions are shown larger

// Every pixel a square.
cv::Mat3b Enlarged(const cv::Mat3b& picture) {
  const int factor = std::max(1, kMinSide / std::max(1, std::min(picture.cols, picture.rows)));
  if (factor == 1) return picture;
  cv::Mat3b large;
  cv::resize(picture, large, {}, factor, factor, cv::INTER_NEAREST);
  return large;
}

ScaleContent Scale(const ValueRange& range, const cv::Mat1f& values) {
  ScaleContent content{.axes = {{.range = range, .unit = "mm"}}};
  for (const float value : values) {
    content.above = content.above || value > range.max;
    content.below = content.below || value < range.min;
  }
  return content;
}

void Frame(cv::Mat3b& picture, const cv::Rect& rect) {
  const int width = std::max(1, picture.cols / 400);
  const cv::Rect outer(rect.x - width, rect.y - width, rect.width + 2 * width,
                       rect.height + 2 * width);
  cv::rectangle(picture, outer, {0, 0, 0}, 3 * width);
  cv::rectangle(picture, outer, {255, 255, 255}, width);
}

}  // namespace

cv::Mat3b RegionPicture(const Measurement& measurement) {
  const TargetMeter& meter = measurement.meter();
  const cv::Mat1f& px = measurement.newest_px();
  std::vector<float> values;
  for (const float d : px) {
    if (std::isfinite(d)) values.push_back(d);
  }
  const ValueRange range = RobustRange(std::move(values));
  cv::Mat3b picture = Colorize(px, range);
  Frame(picture, meter.region());
  if (meter.edge()) Frame(picture, *meter.edge());
  return ScaledPicture(picture, "Disparity and region", DisparityScale(range, &meter.pair()));
}

cv::Mat3b ResidualPicture(const TargetMaps& maps, const TargetQuality& quality) {
  const double reach_mm = RoundStep(std::max(1e-3, 3 * quality.plane_rms_mm.value_or(1)));
  const ValueRange range{.min = -reach_mm, .max = reach_mm};
  return ScaledPicture(Enlarged(Colorize(maps.residual_mm, range)), "Depth minus plane, mean",
                       Scale(range, maps.residual_mm));
}

cv::Mat3b NoisePicture(const TargetMaps& maps, const TargetQuality& quality) {
  const ValueRange range{
      .min = 0, .max = RoundStep(std::max(1e-3, 2 * quality.temporal_noise_95_mm.value_or(1)))};
  return ScaledPicture(Enlarged(Colorize(maps.noise_mm, range)), "Temporal noise",
                       Scale(range, maps.noise_mm));
}

}  // namespace sprout::quality
