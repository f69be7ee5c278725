#include "common/picture/color_map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "common/core/quantile.h"

namespace sprout {
namespace {

constexpr int kColors = 256;
using ColorTable = std::array<cv::Vec3b, kColors>;

ColorTable MakeColorTable() {
  // TURBO starts at a nearly black violet and ends in a dark red: leave both out.
  constexpr int kFirst = 18;
  constexpr int kLast = 246;
  cv::Mat1b indices(1, kColors);
  for (int i = 0; i < kColors; ++i) {
    indices(0, i) = cv::saturate_cast<uchar>(kFirst + i * (kLast - kFirst) / (kColors - 1));
  }
  cv::Mat3b colors;
  cv::applyColorMap(indices, colors, cv::COLORMAP_TURBO);
  ColorTable table;
  std::copy(colors.begin(), colors.end(), table.begin());
  return table;
}

}  // namespace

cv::Vec3b ColorOf(double value, const ValueRange& range) {
  static const ColorTable table = MakeColorTable();
  if (!std::isfinite(value)) return kNoValueColor;
  const double share = std::clamp((value - range.min) / (range.max - range.min), 0.0, 1.0);
  return table[static_cast<size_t>(std::lround(share * (kColors - 1)))];
}

cv::Mat3b Colorize(const cv::Mat1f& values, const ValueRange& range) {
  cv::Mat3b colors(values.size());
  std::transform(values.begin(), values.end(), colors.begin(),
                 [&range](float value) { return ColorOf(value, range); });
  return colors;
}

double ShareOfDepth(double depth_m, const ValueRange& range_m) {
  const double far = 1 / range_m.max;
  return (1 / depth_m - far) / (1 / range_m.min - far);
}

cv::Vec3b ColorOfDepth(double depth_m, const ValueRange& range_m) {
  if (!std::isfinite(depth_m) || depth_m <= 0) return kNoValueColor;
  return ColorOf(ShareOfDepth(depth_m, range_m), {0, 1});
}

cv::Mat3b ColorizeDepth(const cv::Mat1f& depth_m, const ValueRange& range_m) {
  cv::Mat3b colors(depth_m.size());
  std::transform(depth_m.begin(), depth_m.end(), colors.begin(),
                 [&range_m](float depth) { return ColorOfDepth(depth, range_m); });
  return colors;
}

double RoundStep(double at_least) {
  const double power = std::pow(10.0, std::floor(std::log10(at_least)));
  for (double factor : {1.0, 2.0, 5.0}) {
    // Tolerant, because neither the logarithm nor 0.1 is exact: 0.2 must give 0.2, not 0.5.
    if (factor * power >= at_least * (1 - 1e-9)) return factor * power;
  }
  return 10 * power;
}

ValueRange RobustRange(std::vector<float> values) {
  std::erase_if(values, [](float value) { return !std::isfinite(value); });
  if (values.empty()) return {};
  const auto value_at = [&values](double index) {
    return double{OrderStatistic(values, static_cast<size_t>(index))};
  };
  const double last = static_cast<double>(values.size() - 1);
  const double low = value_at(std::floor(0.01 * last));
  const double high = value_at(std::ceil(0.99 * last));
  if (low == high) {
    const double margin = std::max(1.0, 1e-3 * std::abs(low));  // 1e20 + 1 is 1e20
    return {low - margin, high + margin};
  }
  const double step = RoundStep((high - low) / 25);
  return {std::floor(low / step) * step, std::ceil(high / step) * step};
}

ValueRange DisparityRange(std::span<const DisparityImage> maps, std::span<const Seed> seeds) {
  std::vector<float> values;
  for (const DisparityImage& map : maps) {
    for (int16_t counts : map.counts()) {
      if (counts == DisparityImage::kInvalid) continue;
      values.push_back(static_cast<float>(counts) / DisparityImage::kCountsPerPixel);
    }
  }
  for (const Seed& seed : seeds) values.push_back(seed.disparity());
  return RobustRange(std::move(values));
}

std::optional<ValueRange> InFront(const RectifiedPair& pair, const ValueRange& range_px) {
  const double infinity_px = pair.cx - pair.cx_right;
  if (range_px.max <= infinity_px) return std::nullopt;
  return ValueRange{std::max(range_px.min, infinity_px), range_px.max};
}

ValueRange DepthRange(const RectifiedPair& pair, const ValueRange& range_px) {
  const auto depth_m = [&pair](double disparity_px) {
    const double px = disparity_px + pair.cx_right - pair.cx;
    return px > 0 ? pair.focal_px * pair.baseline_m / px : std::numeric_limits<double>::infinity();
  };
  return {depth_m(range_px.max), depth_m(range_px.min)};
}

ValueRange DepthRange(const TofImage& tof) {
  std::vector<float> returns;  // not from begin() and end(): the image may be empty
  for (const float depth_m : tof.depth_m) {
    if (IsReturn(depth_m)) returns.push_back(depth_m);
  }
  ValueRange range = RobustRange(returns);
  if (range.min > 0) return range;
  // Rounded down to 0 or below, where no depth is: down to 1, 2 or 5 times a power of ten instead.
  if (returns.empty()) return {0.1, 1};
  const float low =
      OrderStatistic(returns, static_cast<size_t>(0.01 * static_cast<double>(returns.size() - 1)));
  range.min = 1 / RoundStep(1.001 / low);
  return range;
}

cv::Mat1f ReturnsOnly(const cv::Mat1f& depth_m) {
  cv::Mat1f returns(depth_m.size());
  std::transform(depth_m.begin(), depth_m.end(), returns.begin(), [](float depth) {
    return IsReturn(depth) ? depth : std::numeric_limits<float>::quiet_NaN();
  });
  return returns;
}

}  // namespace sprout
