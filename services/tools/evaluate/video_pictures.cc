#include "services/tools/evaluate/video_pictures.h"

#include <fmt/core.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "common/core/image.h"
#include "common/core/output_file.h"
#include "common/measure/score.h"
#include "common/picture/html.h"
#include "common/picture/picture.h"
#include "common/picture/write_image.h"

namespace sprout::evaluate {
namespace {

constexpr int kStripRows = 6;
constexpr std::array<const char*, 3> kLineColors = {"#888888", "#3070c0", "#c03020"};

std::string FileName(std::string source) {
  std::ranges::replace_if(
      source, [](unsigned char c) { return std::isalnum(c) == 0 && c != '.' && c != '-'; }, '_');
  return source;
}

double BadPercent(const cv::Mat1f& map, const cv::Mat1f& truth, const cv::Mat1b& mask) {
  int64_t bad = 0, pixels = 0;
  for (int v = 0; v < map.rows; ++v) {
    for (int u = 0; u < map.cols; ++u) {
      if (mask(v, u) == 0 || !std::isfinite(truth(v, u))) continue;
      ++pixels;
      bad += std::abs(map(v, u) - truth(v, u)) <= 3 ? 0 : 1;
    }
  }
  return pixels == 0 ? std::nan("")
                     : 100.0 * static_cast<double>(bad) / static_cast<double>(pixels);
}

// A line for each map, over the numbers of the frames.
std::string PlotSvg(const std::string& title, const std::array<std::vector<double>, 3>& lines) {
  constexpr double kWidth = 480, kHeight = 200, kLeft = 44, kTop = 22, kBottom = 24;
  double top = 0;
  for (const auto& line : lines) {
    for (const double value : line) top = std::max(top, value);  // not for NaN
  }
  if (top == 0) top = 1;
  const auto frames = static_cast<double>(std::max<size_t>(2, lines[0].size()) - 1);
  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" viewBox=\"0 0 {0} "
      "{1}\" "
      "font-family=\"sans-serif\" font-size=\"11\"><rect width=\"{0}\" height=\"{1}\" "
      "fill=\"#fff\"/>"
      "<text x=\"4\" y=\"13\">{2}: bad 3, %</text><text x=\"4\" y=\"{3:.0f}\">{4:.1f}</text>"
      "<text x=\"4\" y=\"{5:.0f}\">0</text><text x=\"{6:.0f}\" y=\"{7:.0f}\">frame "
      "{8:.0f}</text>\n",
      kWidth, kHeight, EscapedHtml(title), kTop + 8, top, kHeight - kBottom, kWidth - 70,
      kHeight - 6, frames);
  for (size_t i = 0; i < lines.size(); ++i) {
    std::string points;
    for (size_t k = 0; k < lines[i].size(); ++k) {
      if (std::isnan(lines[i][k])) continue;
      points += fmt::format("{:.1f},{:.1f} ",
                            kLeft + (kWidth - kLeft - 8) * static_cast<double>(k) / frames,
                            kHeight - kBottom - (kHeight - kBottom - kTop) * lines[i][k] / top);
    }
    svg += fmt::format(
        "<polyline fill=\"none\" stroke=\"{0}\" stroke-width=\"1.5\" points=\"{1}\"/>"
        "<text x=\"{2}\" y=\"{3:.0f}\" fill=\"{0}\">{4}</text>\n",
        kLineColors[i], points, kLeft + 70 * static_cast<double>(i), kHeight - 6,
        kVideoMapNames[i]);
  }
  return svg + "</svg>\n";
}

}  // namespace

VideoPictures::VideoPictures(const std::string& source, int frames)
    : source_(source), every_(std::max(1, (frames + kStripRows - 1) / kStripRows)) {}

void VideoPictures::Add(int frame, const cv::Mat& left, const cv::Mat1f& truth,
                        const cv::Mat1b& mask, const VideoMaps& maps) {
  FigureRow row{.cells = {{FigureThumbnail(ToBgr(left)), fmt::format("frame {}", frame)}},
                .scale = {.axes = {{{0, kLargestErrorPx}, "px"}}, .above = true}};
  for (size_t i = 0; i < maps.size(); ++i) {
    const double bad = BadPercent(maps[i], truth, mask);
    bad3_percent_[i].push_back(bad);
    if (frame % every_ != 0) continue;
    row.cells.push_back({FigureThumbnail(ColorizeErrors(ErrorMap(maps[i], truth, mask))),
                         std::isnan(bad) ? "" : fmt::format("bad 3: {:.2f} %", bad)});
  }
  if (frame % every_ == 0) rows_.push_back(std::move(row));
}

void VideoPictures::Write(const std::filesystem::path& folder) const {
  const auto check = [](const Result<void>& written) {
    if (!written) throw std::runtime_error(written.error().text);
  };
  const std::string name = FileName(source_);
  std::vector<std::string> titles = {"left image"};
  titles.insert(titles.end(), kVideoMapNames.begin(), kVideoMapNames.end());
  check(WritePng(folder / (name + "_strip.png"), Figure(titles, rows_)));
  OutputFile plot(folder / (name + ".svg"));
  plot.Write(PlotSvg(source_, bad3_percent_));
  check(plot.Commit());
}

}  // namespace sprout::evaluate
