#ifndef SPROUT_COMMON_PICTURE_CHART_H_
#define SPROUT_COMMON_PICTURE_CHART_H_

#include <string>
#include <vector>

namespace sprout {

/// A distribution as an inline SVG: bars for A, a line for B over them. Values that are not there
/// are left out; those in the outermost hundredth are counted in the first and last bar.
/// @param b     empty: A alone.
/// @param bars  the bars' class in the page's style: "a", or "both" for what is of both. O(n log
/// n).
std::string HistogramSvg(const std::string& title, const std::vector<float>& a,
                         const std::vector<float>& b, const std::string& bars = "a");

/// The course of a value along a log as an inline SVG of the size of a line of text: the largest of
/// each stretch. @param top  value at the upper edge, > 0. O(n).
std::string StripSvg(const std::vector<float>& values, double top);

}  // namespace sprout

#endif  // SPROUT_COMMON_PICTURE_CHART_H_
