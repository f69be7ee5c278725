#include "common/picture/html.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <opencv2/imgcodecs.hpp>

#include "common/core/quantile.h"

namespace sprout {
namespace {

constexpr char kStyle[] =
    R"(body { font: 15px/1.45 sans-serif; max-width: 1440px; margin: 2em auto; padding: 0 1em; color: #1c1c1c; }
h1 { font-size: 1.6em; } h2 { margin-top: 1.6em; border-bottom: 1px solid #ccc; }
table { border-collapse: collapse; margin: 1em 0; }
th, td { border-bottom: 1px solid #e2e2e2; padding: .25em 1em .25em 0; text-align: left; }
th { color: #555; font-weight: normal; }
figure { display: inline-block; margin: .5em 1.5em .5em 0; vertical-align: top; }
figcaption { color: #444; } img { max-width: 100%; border: 1px solid #ddd; }
.chart text { font: 11px sans-serif; fill: #555; } .axis { stroke: #999; } .a { fill: #9dbbd8; }
.good { color: #176117; } .bad { color: #a31515; }
)";

std::string Base64(std::span<const uint8_t> bytes) {
  static constexpr char kDigits[] =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (size_t i = 0; i < bytes.size(); i += 3) {
    const auto byte = [&](size_t k) { return i + k < bytes.size() ? uint32_t{bytes[i + k]} : 0U; };
    const uint32_t triple = byte(0) << 16 | byte(1) << 8 | byte(2);
    for (uint32_t digit = 0; digit < 4; ++digit) {
      const bool is_there = i + digit <= bytes.size();
      text += is_there ? kDigits[triple >> (18 - 6 * digit) & 63] : '=';
    }
  }
  return text;
}

constexpr int kBins = 40;
constexpr double kWidth = 360;
constexpr double kHeight = 120;

std::vector<float> Present(const std::vector<float>& values) {
  std::vector<float> present;
  for (const float value : values) {
    if (!std::isnan(value)) present.push_back(value);
  }
  return present;
}

struct Bounds {
  double low;
  double high;
};

Bounds BoundsOf(std::vector<float> values) {
  const size_t rank = values.size() / 100;
  const double low = OrderStatistic(values, rank);
  const double high = OrderStatistic(values, values.size() - 1 - rank);
  return high > low ? Bounds{low, high} : Bounds{low - 0.5, low + 0.5};
}

std::vector<double> SharesOf(const std::vector<float>& values, const Bounds& bounds) {
  std::vector<double> shares(kBins, 0);
  for (const float value : values) {
    const double place = (value - bounds.low) / (bounds.high - bounds.low) * kBins;
    shares[static_cast<size_t>(std::clamp(place, 0.0, kBins - 1.0))] +=
        1.0 / static_cast<double>(values.size());
  }
  return shares;
}

// Around a plot, px.
constexpr double kMargin = 56;

std::string TextSvg(cv::Point2d at, const std::string& text, const char* attributes = "") {
  return fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" {}>{}</text>", at.x, at.y, attributes,
                     EscapedHtml(text));
}

std::string AxesSvg(const LinePlot& plot, cv::Point2d corner) {
  constexpr const char* kMiddle = "text-anchor=\"middle\"";
  const cv::Size2d size = plot.size;
  std::string svg = fmt::format(
      "<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" stroke=\"#888\"/>",
      corner.x, corner.y, size.width, size.height);
  for (const double share : {0.0, 0.5, 1.0}) {
    svg += TextSvg(corner + cv::Point2d(share * size.width, size.height + 16),
                   fmt::format("{:.4g}", share * plot.right), kMiddle) +
           TextSvg(corner + cv::Point2d(-6, (1 - share) * size.height + 4),
                   fmt::format("{:.4g}", share * plot.top), "text-anchor=\"end\"");
  }
  return svg + TextSvg(corner + cv::Point2d(0, -30), plot.title, "font-size=\"15\"") +
         TextSvg(corner + cv::Point2d(0, -8), plot.up) +
         TextSvg(corner + cv::Point2d(size.width / 2, size.height + 34), plot.along, kMiddle);
}

std::string PlotSvg(const LinePlot& plot, cv::Point2d corner) {
  std::string svg = AxesSvg(plot, corner);
  double name_x = 0;
  for (const LinePlot::Line& line : plot.lines) {
    std::string points;
    for (const cv::Point2d& point : line.points) {
      if (!std::isfinite(point.y)) continue;
      points += fmt::format("{}{:.1f},{:.1f}", points.empty() ? "" : " ",
                            corner.x + std::min(point.x / plot.right, 1.0) * plot.size.width,
                            corner.y + (1 - std::min(point.y / plot.top, 1.0)) * plot.size.height);
    }
    svg += fmt::format("<polyline stroke=\"{}\" stroke-width=\"{}\"{} points=\"{}\"/>", line.color,
                       line.width, line.dashed ? " stroke-dasharray=\"5 4\"" : "", points);
    if (line.name.empty()) continue;
    svg += TextSvg(corner + cv::Point2d(name_x, plot.size.height + 34), line.name,
                   fmt::format("fill=\"{}\"", line.color).c_str());
    name_x += 70;
  }
  return svg + "\n";
}

}  // namespace

std::string EscapedHtml(std::string_view text) {
  std::string escaped;
  for (const char c : text) {
    switch (c) {
      case '&':
        escaped += "&amp;";
        break;
      case '<':
        escaped += "&lt;";
        break;
      case '>':
        escaped += "&gt;";
        break;
      case '"':
        escaped += "&quot;";
        break;
      default:
        escaped += c;
    }
  }
  return escaped;
}

std::string DataUrl(std::string_view type, std::span<const uint8_t> bytes) {
  return "data:" + std::string(type) + ";base64," + Base64(bytes);
}

std::string FigureHtml(const cv::Mat3b& picture, std::string_view caption) {
  std::vector<uint8_t> png;
  cv::imencode(".png", picture, png);
  return fmt::format("<figure><img alt=\"\" src=\"{}\"><figcaption>{}</figcaption></figure>\n",
                     DataUrl("image/png", png), caption);
}

std::string PageStart(std::string_view title, std::string_view style) {
  return fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>{}</title>\n"
      "<style>\n{}{}</style></head><body>\n",
      EscapedHtml(title), kStyle, style);
}

std::string PageEnd() { return "</body></html>\n"; }

std::string TableHtml(const std::vector<std::vector<std::string>>& rows) {
  std::string html = "<table>\n";
  for (size_t i = 0; i < rows.size(); ++i) {
    html += "<tr>";
    for (const std::string& cell : rows[i]) {
      html += fmt::format("<{0}>{1}</{0}>", i == 0 ? "th" : "td", EscapedHtml(cell));
    }
    html += "</tr>\n";
  }
  return html + "</table>\n";
}

std::string HistogramSvg(const std::string& title, const std::vector<float>& a,
                         const std::vector<float>& b, const std::string& bars) {
  const std::vector<float> in_a = Present(a);
  const std::vector<float> in_b = Present(b);
  if (in_a.empty() && in_b.empty()) return "";
  std::vector<float> all = in_a;
  all.insert(all.end(), in_b.begin(), in_b.end());
  const Bounds bounds = BoundsOf(std::move(all));
  const std::vector<double> shares_a = SharesOf(in_a, bounds);
  const std::vector<double> shares_b = SharesOf(in_b, bounds);
  const double top = std::max(*std::max_element(shares_a.begin(), shares_a.end()),
                              *std::max_element(shares_b.begin(), shares_b.end()));
  const double bar = kWidth / kBins;
  std::string svg = fmt::format(
      "<figure class=\"chart\"><figcaption>{}</figcaption><svg viewBox=\"0 0 {} {}\" "
      "width=\"{}\" height=\"{}\">",
      EscapedHtml(title), kWidth, kHeight + 18, kWidth, kHeight + 18);
  std::string line;
  for (size_t i = 0; i < kBins; ++i) {
    const double x = static_cast<double>(i) * bar;
    const double height = shares_a[i] / top * (kHeight - 4);
    svg += fmt::format(
        "<rect class=\"{}\" x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\"/>", bars,
        x, kHeight - height, bar - 1, height);
    const double y = kHeight - shares_b[i] / top * (kHeight - 4);
    line += fmt::format("{}{:.1f},{:.1f} {:.1f},{:.1f}", i == 0 ? "" : " ", x, y, x + bar, y);
  }
  if (!in_b.empty()) svg += fmt::format("<polyline class=\"b\" points=\"{}\"/>", line);
  return svg + fmt::format(
                   "<line class=\"axis\" x1=\"0\" x2=\"{0}\" y1=\"{1}\" y2=\"{1}\"/>"
                   "<text x=\"0\" y=\"{2}\">{3:.4g}</text>"
                   "<text x=\"{0}\" y=\"{2}\" text-anchor=\"end\">{4:.4g}</text></svg></figure>\n",
                   kWidth, kHeight, kHeight + 14, bounds.low, bounds.high);
}

std::string StripSvg(const std::vector<float>& values, double top) {
  constexpr size_t kSteps = 160;
  constexpr double kStripHeight = 22;
  const size_t steps = std::min(kSteps, std::max<size_t>(values.size(), 1));
  std::string points;
  for (size_t i = 0; i < steps; ++i) {
    double largest = 0;
    for (size_t k = i * values.size() / steps; k < (i + 1) * values.size() / steps; ++k) {
      if (!std::isnan(values[k])) largest = std::max(largest, double{values[k]});
    }
    const double y = kStripHeight - std::min(1.0, largest / top) * (kStripHeight - 1);
    const double x = static_cast<double>(i) * kSteps / static_cast<double>(steps);
    const double end = static_cast<double>(i + 1) * kSteps / static_cast<double>(steps);
    points += fmt::format("{:.1f},{:.1f} {:.1f},{:.1f} ", x, y, end, y);
  }
  return fmt::format(
      "<svg class=\"strip\" viewBox=\"0 0 {0} {1}\" width=\"{0}\" height=\"{1}\">"
      "<polygon points=\"0,{1} {2}{0},{1}\"/></svg>",
      kSteps, kStripHeight, points);
}

std::string PlotsSvg(const std::vector<std::vector<LinePlot>>& rows) {
  std::string plots;
  cv::Size2d all(0, 0);
  for (const std::vector<LinePlot>& row : rows) {
    cv::Size2d used(0, 0);
    for (const LinePlot& plot : row) {
      plots += PlotSvg(plot, {used.width + kMargin, all.height + kMargin});
      used.width += plot.size.width + 2 * kMargin;
      used.height = std::max(used.height, plot.size.height + 2 * kMargin);
    }
    all = {std::max(all.width, used.width), all.height + used.height};
  }
  return fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0:.0f}\" height=\"{1:.0f}\" "
      "viewBox=\"0 0 {0:.0f} {1:.0f}\" font-family=\"sans-serif\" font-size=\"12\">\n"
      "<style>rect, polyline {{ fill: none }}</style>\n"
      "<rect style=\"fill: #fff\" width=\"{0:.0f}\" height=\"{1:.0f}\"/>\n{2}</svg>\n",
      all.width, all.height, plots);
}

}  // namespace sprout
