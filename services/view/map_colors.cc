#include "services/view/map_colors.h"

#include <fmt/core.h>

#include <array>
#include <limits>

namespace sprout::view {
namespace {

constexpr int kSampleColumns = 160;

// A range of colours is kept while values fill at least this share of it, and leave it by at most
// this margin.
constexpr double kMinFilled = 0.5;
constexpr double kMargin = 0.05;

// ColorOf(), some times faster.
class Palette {
 public:
  explicit Palette(const ValueRange& range)
      : range_(range),
        steps_per_unit_(kSteps / (range.max - range.min)),
        below_(ColorOf(2 * range.min - range.max, range)),
        above_(ColorOf(2 * range.max - range.min, range)) {
    for (size_t i = 0; i <= kSteps; ++i) colors_[i] = ColorOf(static_cast<double>(i), {0, kSteps});
  }

  /// @param value  no NaN.
  const cv::Vec3b& Of(double value) const {
    if (value < range_.min) return below_;
    if (value > range_.max) return above_;
    return colors_[static_cast<size_t>((value - range_.min) * steps_per_unit_ + 0.5)];
  }

 private:
  static constexpr size_t kSteps = 255;

  ValueRange range_;
  double steps_per_unit_;
  cv::Vec3b below_;
  cv::Vec3b above_;
  std::array<cv::Vec3b, kSteps + 1> colors_;
};

size_t IndexOf(int16_t count) { return static_cast<uint16_t>(count); }

}  // namespace

std::string ScaleColors() {
  std::string text;
  for (int i = 0; i < 256; ++i) {
    const cv::Vec3b bgr = ColorOf(i, {0, 255});
    text += fmt::format("{:02x}{:02x}{:02x}", bgr[2], bgr[1], bgr[0]);
  }
  return text;
}

template <typename ColorOfPx>
CountColors::CountColors(ColorOfPx color_of_px) : table_(1 << 16, kNoValueColor) {
  for (int count = DisparityImage::kInvalid + 1; count <= std::numeric_limits<int16_t>::max();
       ++count) {
    table_[IndexOf(static_cast<int16_t>(count))] =
        color_of_px(static_cast<double>(count) / DisparityImage::kCountsPerPixel);
  }
}

CountColors CountColors::OfDisparity(const ValueRange& range_px) {
  return CountColors([palette = Palette(range_px)](double px) { return palette.Of(px); });
}

CountColors CountColors::OfDepth(const RectifiedPair& pair, const ValueRange& range_m) {
  const Palette palette({0, 1});
  return CountColors([&](double px) {
    const double depth_m = pair.DepthFromDisparity(px);
    return depth_m > 0 ? palette.Of(ShareOfDepth(depth_m, range_m)) : kNoValueColor;
  });
}

cv::Mat3b CountColors::Paint(const cv::Mat1s& counts) const {
  cv::Mat3b picture(counts.size());
  for (int v = 0; v < counts.rows; ++v) {
    std::transform(counts[v], counts[v] + counts.cols, picture[v],
                   [this](int16_t count) { return table_[IndexOf(count)]; });
  }
  return picture;
}

ValueRange StableRange::Follow(const ValueRange& range) {
  if (range_) {
    const double span = range_->max - range_->min;
    const bool inside =
        range.min >= range_->min - kMargin * span && range.max <= range_->max + kMargin * span;
    if (inside && range.max - range.min >= kMinFilled * span) return *range_;
  }
  range_ = range;
  return range;
}

ValueRange DisparityRangeOf(const DisparityImage& map) {
  std::vector<float> values;
  for (const int16_t count : Thin(map.counts(), kSampleColumns)) {
    if (count == DisparityImage::kInvalid) continue;
    values.push_back(static_cast<float>(count) / DisparityImage::kCountsPerPixel);
  }
  return RobustRange(std::move(values));
}

ValueRange DepthRangeOf(const DisparityImage& map, const RectifiedPair& pair) {
  std::vector<float> values;
  for (const int16_t count : Thin(map.counts(), kSampleColumns)) {
    if (count == DisparityImage::kInvalid) continue;
    const double depth_m =
        pair.DepthFromDisparity(static_cast<double>(count) / DisparityImage::kCountsPerPixel);
    if (depth_m > 0) values.push_back(static_cast<float>(depth_m));
  }
  if (values.empty()) return {0.1, 1};
  const double nearest = *std::ranges::min_element(values);
  ValueRange range = RobustRange(std::move(values));
  range.min = std::max(range.min, nearest);  // rounded outward it may be 0
  return range;
}

}  // namespace sprout::view
