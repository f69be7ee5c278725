#include "common/picture/color_scale.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "common/picture/text.h"

namespace sprout {
namespace {

const cv::Vec3b kInk{48, 48, 48};

std::string Label(double value, int decimals) {
  char text[64];  // FLT_MAX has 39 digits
  std::snprintf(text, sizeof text, "%.*f", decimals, value);
  return text;
}

// All widths follow the text.
int BarWidth(int cap_height) { return 3 * cap_height / 2; }
int TickLength(int cap_height) { return cap_height / 2; }
int LabelOffset(int cap_height) { return BarWidth(cap_height) + cap_height; }
int LineThickness(int cap_height) { return std::max(1, cap_height / 12); }

}  // namespace

std::vector<Tick> RoundTicks(const ValueRange& range, int max_count) {
  // The tolerance keeps ticks at the ends of a range that is itself a rounded product.
  constexpr double kTolerance = 1e-6;
  const double step = RoundStep((range.max - range.min) / (max_count - 1));
  const auto first = static_cast<int64_t>(std::ceil(range.min / step - kTolerance));
  const auto last = static_cast<int64_t>(std::floor(range.max / step + kTolerance));
  const int decimals = std::max(0, -static_cast<int>(std::floor(std::log10(step) + kTolerance)));
  std::vector<Tick> ticks;
  for (int64_t i = first; i <= last; ++i) {
    const double value = static_cast<double>(i) * step;
    ticks.push_back({value, Label(value, decimals)});
  }
  return ticks;
}

ColorScale::ColorScale(const ValueRange& range, std::string unit, int height, int cap_height)
    : range_(range),
      unit_(std::move(unit)),
      height_(height),
      cap_height_(cap_height),
      ticks_(RoundTicks(range, std::clamp(height / (4 * cap_height), 2, 9))) {
  int labels = 0;
  for (const Tick& tick : ticks_) labels = std::max(labels, TextWidth(tick.label, cap_height));
  width_ = std::max(LabelOffset(cap_height) + labels, TextWidth(unit_, cap_height));
}

void ColorScale::Draw(cv::Mat3b& picture, cv::Point corner, int unit_baseline_y) const {
  const cv::Rect bar(corner, cv::Size(BarWidth(cap_height_), height_));
  const double value_per_px = (range_.max - range_.min) / std::max(1, height_ - 1);
  for (int row = 0; row < height_; ++row) {
    picture(cv::Rect(bar.x, bar.y + row, bar.width, 1)) =
        ColorOf(range_.max - row * value_per_px, range_);
  }
  const int thickness = LineThickness(cap_height_);
  for (const Tick& tick : ticks_) {
    const int y = std::clamp(cvRound(bar.y + (range_.max - tick.value) / value_per_px), bar.y,
                             bar.y + height_ - 1);
    picture(cv::Rect(bar.x + bar.width, y - thickness / 2, TickLength(cap_height_), thickness)) =
        kInk;
    DrawText(picture, tick.label, {bar.x + LabelOffset(cap_height_), y + cap_height_ / 2},
             cap_height_, kInk);
  }
  DrawText(picture, unit_, {bar.x, unit_baseline_y}, cap_height_, kInk);
}

}  // namespace sprout
