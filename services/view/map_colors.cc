#include "services/view/map_colors.h"

#include <fmt/core.h>

#include <limits>

namespace sprout::view {
namespace {

constexpr int kSampleColumns = 160;

// A range of colours is kept while values fill at least this share of it, and leave it by at most
// this margin.
constexpr double kMinFilled = 0.5;
constexpr double kMargin = 0.05;

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
  return CountColors([&](double px) { return ColorOf(px, range_px); });
}

CountColors CountColors::OfDepth(const RectifiedPair& pair, const ValueRange& range_m) {
  return CountColors([&](double px) {
    const double depth_m = pair.DepthFromDisparity(px);
    return depth_m > 0 ? ColorOf(ShareOfDepth(depth_m, range_m), {0, 1}) : kNoValueColor;
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
  range.min = std::max(range.min, nearest);  // rounding outwards may have made it 0
  return range;
}

}  // namespace sprout::view
