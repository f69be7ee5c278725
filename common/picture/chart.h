#ifndef SPROUT_COMMON_PICTURE_CHART_H_
#define SPROUT_COMMON_PICTURE_CHART_H_

#include <string>
#include <vector>

namespace sprout {

/// A distribution as an inline SVG: bars for A, a line for B over them. Missing values are left
/// out; the outermost 1 % on either side are counted in the first and last bar.
/// @param b     empty: A alone.
/// @param bars  the bars' class in the page's style: "a", or "both" if the values belong to both.
/// O(n log n).
std::string HistogramSvg(const std::string& title, const std::vector<float>& a,
                         const std::vector<float>& b, const std::string& bars = "a");

/// A value along a log as an inline SVG of the height of a line of text: the largest of each
/// stretch. @param top  value at the upper edge, > 0. O(n).
std::string StripSvg(const std::vector<float>& values, double top);

}  // namespace sprout

#endif  // SPROUT_COMMON_PICTURE_CHART_H_
