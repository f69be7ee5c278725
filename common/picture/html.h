#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace sprout {

/// Text escaped for HTML: &, <, > and " are shown as such. O(length).
std::string EscapedHtml(std::string_view text);

/// Bytes of a picture embedded in a page: the value of src= of an <img>.
/// @param type  "image/png", "image/jpeg". O(bytes).
std::string DataUrl(std::string_view type, std::span<const uint8_t> bytes);

/// A picture as PNG inside the page, with a caption below it. @param caption  HTML. O(pixels).
std::string FigureHtml(const cv::Mat3b& picture, std::string_view caption);

/// The start of a page, with the style that all reports share.
/// @param style  CSS that this report adds.
std::string PageStart(std::string_view title, std::string_view style = "");
std::string PageEnd();

/// A table of texts, which are escaped; the first row is its head. O(length).
std::string TableHtml(const std::vector<std::vector<std::string>>& rows);

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

/// Lines over two axes from 0 on.
struct LinePlot {
  struct Line {
    std::vector<cv::Point2d> points;  ///< beyond an axis: at its end; without a finite y: left out
    const char* color = "#bbb";
    double width = 1;  ///< px
    bool dashed = false;
    std::string name = {};  ///< below the plot, in the line's colour
  };
  std::string title;
  std::string along, up;         ///< names of the axes
  double right = 1, top = 1;     ///< numbers at the ends of the axes, > 0
  std::vector<Line> lines;       ///< later ones over earlier ones
  cv::Size2d size = {260, 260};  ///< between the axes, px
};

/// Rows of plots as the text of an SVG file. O(points).
std::string PlotsSvg(const std::vector<std::vector<LinePlot>>& rows);

}  // namespace sprout
