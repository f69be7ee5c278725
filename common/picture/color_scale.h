#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "common/picture/color_map.h"

namespace sprout {

/// A labelled position on a colour scale.
struct Tick {
  double value = 0;
  std::string label;
};

/// At most `max_count` ≥ 2 ticks at round values (multiples of 1, 2 or 5 times a power of ten)
/// inside the range, ascending.
std::vector<Tick> RoundTicks(const ValueRange& range, int max_count);

/// Ticks at round depths, as round as space allows, at least `min_gap` apart on a scale of length 1
/// that is linear in 1/depth, and at least as far from both its ends; from near to far.
/// @param range_m  0 < min < max; max may be infinite.
std::vector<Tick> RoundDepthTicks(const ValueRange& range_m, double min_gap);

/// The numbers along a scale.
struct ScaleAxis {
  ValueRange range;
  std::string unit;
  bool is_depth = false;  ///< linear in 1/value, the smallest value on top, see ShareOfDepth()
};

/// A scale and its labels.
struct ScaleContent {
  /// One or two. The first is on the right of the bar with a number at either end; the second, the
  /// same in another unit, on its left.
  std::vector<ScaleAxis> axes;
  /// Whether the picture has values beyond the upper and the lower end of the bar: marked by an
  /// arrow there, and "<" or ">" before the number.
  bool above = false;
  bool below = false;
  bool grey = false;  ///< from black to white, not from blue to red
};

/// A vertical colour scale: bar, ticks, numbers, and the units above. It has numbers at every size.
class ColorScale {
 public:
  /// @param height  of the bar, px; at least MinHeight().
  /// @param cap_height  of the numbers, px; sets all widths.
  ColorScale(ScaleContent content, int height, int cap_height);

  /// The least height of a bar whose numbers do not touch, px.
  static int MinHeight(int cap_height) { return 4 * cap_height; }

  /// Width of numbers, ticks and bar together, px.
  int width() const { return width_; }
  int height() const { return height_; }

  /// Draws the scale with its upper left corner at `corner`: the bar begins at that height.
  /// The units are written above, on a line whose baseline is at `unit_baseline_y`. Arrows and
  /// numbers reach less than cap_height above and below the bar.
  void Draw(cv::Mat3b& picture, cv::Point corner, int unit_baseline_y) const;

 private:
  struct Mark {
    double share = 0;  // of the bar, from below
    std::string label;
  };
  struct Column {
    std::string unit;
    std::vector<Mark> marks;
    int width = 0;  // of the widest text
  };

  Column PrimaryColumn(const ScaleAxis& axis) const;
  Column SecondColumn(const ScaleAxis& axis) const;
  double MinGap() const;
  cv::Vec3b ColorAt(double share) const;
  void DrawBar(cv::Mat3b& picture, const cv::Rect& bar) const;

  ScaleContent content_;
  int height_;
  int cap_height_;
  std::vector<Column> columns_;
  int width_ = 0;
};

}  // namespace sprout
