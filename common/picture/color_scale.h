#ifndef SPROUT_COMMON_PICTURE_COLOR_SCALE_H_
#define SPROUT_COMMON_PICTURE_COLOR_SCALE_H_

#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "common/picture/color_map.h"

namespace sprout {

/// A labelled place on a colour scale.
struct Tick {
  double value = 0;
  std::string label;
};

/// At most `max_count` ≥ 2 ticks at round values (multiples of 1, 2 or 5 times a power of ten)
/// inside the range, ascending.
std::vector<Tick> RoundTicks(const ValueRange& range, int max_count);

/// A vertical colour scale, the largest value on top: bar, ticks, numbers, and the unit above.
class ColorScale {
 public:
  /// @param height  of the bar, px.
  /// @param cap_height  of the numbers, px; sets all widths.
  ColorScale(const ValueRange& range, std::string unit, int height, int cap_height);

  /// Width of bar, ticks and widest number together, px.
  int width() const { return width_; }

  /// Draws the scale with the upper left corner of its bar at `corner`. The unit is written above
  /// that, on a line whose baseline is at `unit_baseline_y`.
  void Draw(cv::Mat3b& picture, cv::Point corner, int unit_baseline_y) const;

 private:
  ValueRange range_;
  std::string unit_;
  int height_;
  int cap_height_;
  std::vector<Tick> ticks_;
  int width_;
};

}  // namespace sprout

#endif  // SPROUT_COMMON_PICTURE_COLOR_SCALE_H_
