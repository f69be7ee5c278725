#include "common/picture/html.h"

#include <fmt/core.h>

#include <cstddef>
#include <opencv2/imgcodecs.hpp>

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

}  // namespace sprout
