#include "common/picture/color_scale.h"

#include <fmt/core.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "common/picture/text.h"

namespace sprout {
namespace {

const cv::Vec3b kInk{48, 48, 48};

std::string Fixed(double value, int decimals) { return fmt::format("{:.{}f}", value, decimals); }

// A number with the decimals that multiples of a power of ten need, without trailing zeros.
std::string Shortest(double value, double power) {
  const int magnitude = static_cast<int>(std::floor(std::log10(power) + 1e-6));
  std::string text = Fixed(value, std::max(0, -magnitude));
  if (text.find('.') == std::string::npos) return text;
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text == "-0" ? "0" : text;
}

// All widths follow the text.
int BarWidth(int cap_height) { return 3 * cap_height / 2; }
int TickLength(int cap_height) { return cap_height / 2; }
int LineThickness(int cap_height) { return std::max(1, cap_height / 12); }

double ShareOf(double value, const ScaleAxis& axis) {
  if (axis.is_depth) return ShareOfDepth(value, axis.range);
  return (value - axis.range.min) / (axis.range.max - axis.range.min);
}

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
    ticks.push_back({value, Fixed(value, decimals)});
  }
  return ticks;
}

std::vector<Tick> RoundDepthTicks(const ValueRange& range_m, double min_gap) {
  constexpr int kMaxMultiples = 100;  // of a step; farther ones stand on those of larger steps
  const auto depth_at = [&](double share) {
    const double far = 1 / range_m.max;
    return 1 / (far + share * (1 / range_m.min - far));
  };
  const double nearest = depth_at(1 - min_gap);
  const double farthest = depth_at(min_gap);
  std::vector<Tick> ticks;
  const auto add = [&](double depth, double power) {
    const double share = ShareOfDepth(depth, range_m);
    const bool has_room = std::all_of(ticks.begin(), ticks.end(), [&](const Tick& tick) {
      return std::abs(ShareOfDepth(tick.value, range_m) - share) >= min_gap;
    });
    if (has_room) ticks.push_back({depth, Shortest(depth, power)});
  };
  // From coarse steps to fine ones, down to what the gap can tell apart at the near end.
  const double finest = (nearest - range_m.min) / 2;
  for (double power = std::pow(10.0, std::floor(std::log10(farthest))); 5 * power > finest;
       power /= 10) {
    for (const double factor : {5.0, 2.0, 1.0}) {
      const double step = factor * power;
      const double first = std::ceil(nearest / step);
      for (int i = 0; i < kMaxMultiples && (first + i) * step <= farthest; ++i) {
        add((first + i) * step, power);
      }
    }
  }
  std::sort(ticks.begin(), ticks.end(),
            [](const Tick& a, const Tick& b) { return a.value < b.value; });
  return ticks;
}

ColorScale::ColorScale(ScaleContent content, int height, int cap_height)
    : content_(std::move(content)), height_(height), cap_height_(cap_height) {
  assert(!content_.axes.empty() && content_.axes.size() <= 2 && height >= MinHeight(cap_height));
  columns_.push_back(PrimaryColumn(content_.axes[0]));
  if (content_.axes.size() > 1) columns_.push_back(SecondColumn(content_.axes[1]));
  width_ = BarWidth(cap_height);
  for (Column& column : columns_) {
    column.width = TextWidth(column.unit, cap_height);
    for (const Mark& mark : column.marks) {
      column.width = std::max(column.width, TextWidth(mark.label, cap_height));
    }
    width_ += cap_height + column.width;  // with the ticks
  }
}

double ColorScale::MinGap() const { return 1.8 * cap_height_ / height_; }

ColorScale::Column ColorScale::PrimaryColumn(const ScaleAxis& axis) const {
  Column column{.unit = axis.unit, .marks = {}, .width = 0};
  const auto mark_end = [&](double value, double share, bool beyond, char sign) {
    const std::string label = axis.is_depth
                                  ? fmt::format("{:.3g}", value)
                                  : Shortest(value, (axis.range.max - axis.range.min) / 100);
    column.marks.push_back({share, beyond ? sign + label : label});
  };
  if (axis.is_depth) {
    mark_end(axis.range.max, 0, content_.below, '>');
    mark_end(axis.range.min, 1, content_.above, '<');
  } else {
    mark_end(axis.range.min, 0, content_.below, '<');
    mark_end(axis.range.max, 1, content_.above, '>');
  }
  const std::vector<Tick> ticks =
      axis.is_depth ? RoundDepthTicks(axis.range, std::max(MinGap(), 0.09))
                    : RoundTicks(axis.range, std::clamp(height_ / (4 * cap_height_), 2, 9));
  for (const Tick& tick : ticks) {
    const double share = ShareOf(tick.value, axis);
    if (share > MinGap() && share < 1 - MinGap()) column.marks.push_back({share, tick.label});
  }
  return column;
}

ColorScale::Column ColorScale::SecondColumn(const ScaleAxis& axis) const {
  Column column{.unit = axis.unit, .marks = {}, .width = 0};
  const double gap = std::max(MinGap(), 0.09);
  const std::vector<Tick> ticks =
      axis.is_depth ? RoundDepthTicks(axis.range, gap)
                    : RoundTicks(axis.range, std::clamp(static_cast<int>(1 / gap), 2, 9));
  for (const Tick& tick : ticks) column.marks.push_back({ShareOf(tick.value, axis), tick.label});
  return column;
}

cv::Vec3b ColorScale::ColorAt(double share) const {
  return content_.grey ? cv::Vec3b::all(cv::saturate_cast<uchar>(255 * share))
                       : ColorOf(share, {0, 1});
}

void ColorScale::DrawBar(cv::Mat3b& picture, const cv::Rect& bar) const {
  for (int row = 0; row < bar.height; ++row) {
    picture(cv::Rect(bar.x, bar.y + row, bar.width, 1)) =
        ColorAt(1 - static_cast<double>(row) / (bar.height - 1));
  }
  // Arrows at the ends: what lies beyond has the same colour.
  const int length = 3 * cap_height_ / 4;
  const auto arrow = [&](int base_y, int direction, double share) {
    for (int i = 0; i < length; ++i) {
      const int inset = (i + 1) * bar.width / (2 * (length + 1));
      picture(cv::Rect(bar.x + inset, base_y + direction * i, bar.width - 2 * inset, 1)) =
          ColorAt(share);
    }
  };
  if (content_.above) arrow(bar.y - 1, -1, 1);
  if (content_.below) arrow(bar.br().y, 1, 0);
  if (content_.grey) {  // its white end would vanish on the paper
    cv::rectangle(picture, bar, cv::Scalar(kInk));
  }
}

void ColorScale::Draw(cv::Mat3b& picture, cv::Point corner, int unit_baseline_y) const {
  const bool two_sided = columns_.size() > 1;
  const int bar_x = corner.x + (two_sided ? columns_[1].width + cap_height_ : 0);
  const cv::Rect bar(bar_x, corner.y, BarWidth(cap_height_), height_);
  DrawBar(picture, bar);
  const int thickness = LineThickness(cap_height_);
  const int tick = TickLength(cap_height_);
  for (size_t i = 0; i < columns_.size(); ++i) {
    const Column& column = columns_[i];
    const bool right = i == 0;
    const auto text_x = [&](const std::string& text) {
      return right ? bar.br().x + cap_height_ : bar.x - cap_height_ - TextWidth(text, cap_height_);
    };
    for (const Mark& mark : column.marks) {
      const int y = bar.y + cvRound((1 - mark.share) * (height_ - 1));
      picture(cv::Rect(right ? bar.br().x : bar.x - tick, y - thickness / 2, tick, thickness)) =
          kInk;
      DrawText(picture, mark.label, {text_x(mark.label), y + cap_height_ / 2}, cap_height_, kInk);
    }
    DrawText(picture, column.unit, {text_x(column.unit), unit_baseline_y}, cap_height_, kInk);
  }
}

}  // namespace sprout
